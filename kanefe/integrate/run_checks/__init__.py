"""What a run checks of itself, as it goes on and at its end."""
