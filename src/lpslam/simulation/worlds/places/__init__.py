"""The places: what stands where, how one may move through it, what can be read there."""
