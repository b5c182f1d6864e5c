"""Time integration: a method is a stepper; one loop drives them all."""
