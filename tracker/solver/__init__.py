"""A body fitted to positions of its points."""
