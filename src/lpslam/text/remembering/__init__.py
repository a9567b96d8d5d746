"""What was read, remembered as classes with names (III-C to III-E)."""
