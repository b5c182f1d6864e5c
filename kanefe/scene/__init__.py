"""What the user says of a scene: data with checks, which computes nothing."""
