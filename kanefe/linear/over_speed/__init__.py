"""How modes and stability change with the speed of a scene."""
