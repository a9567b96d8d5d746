"""Which lines are one board, and what each line of it is."""
