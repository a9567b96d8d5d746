"""What a sign says, and which signs are not trusted."""
