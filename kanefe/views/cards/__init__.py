"""Cards in notebooks of a scene, a body, modes or a run."""
