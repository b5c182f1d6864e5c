"""What the machine has: memory, and a folder of compiled forms."""
