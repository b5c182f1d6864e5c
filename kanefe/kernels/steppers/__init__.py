"""Steps of the compiled methods of integration."""
