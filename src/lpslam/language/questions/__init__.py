"""What a question says: its clauses, what is wanted, refused and said by the way."""
