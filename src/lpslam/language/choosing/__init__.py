"""Which landmark serves a question."""
