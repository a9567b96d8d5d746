"""Places seen before: recalling, verifying and joining them."""
