"""Maps served to others: over HTTP, and as tools of language models' agents."""
