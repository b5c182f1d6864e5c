"""Scenes for co-simulation with other programs: functional mock-up units (FMI 2.0 and 3.0)."""
