"""The user's input of a scene: checked data, without computations."""
