"""The methods of integration: a file each, and the table of all."""
