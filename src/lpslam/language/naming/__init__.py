"""Names of what was read many times."""
