"""What notebooks show of a scene, a body, modes or a run."""
