"""Resources of the machine: memory, and the folder of compiled forms."""
