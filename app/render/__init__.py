"""Pictures of a posed body, without a window."""
