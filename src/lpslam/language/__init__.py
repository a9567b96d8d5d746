"""The three uses of a language model: naming, judging, choosing."""
