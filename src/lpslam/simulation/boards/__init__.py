"""Shop boards that look photographed: drawn from a seed or taken from a labelled folder, and hung along a street."""
