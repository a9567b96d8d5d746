"""Texts that say where loops may close, and where not."""
