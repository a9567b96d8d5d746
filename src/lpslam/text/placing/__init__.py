"""Where texts stand, and which are the same thing seen again."""
