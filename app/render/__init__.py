"""Draw pictures of a posed body, without a window."""
