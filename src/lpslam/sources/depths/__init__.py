"""What raw numbers of depth pictures mean: as it is stated, and whether the pictures agree."""
