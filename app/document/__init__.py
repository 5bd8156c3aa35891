"""Create, open, save and list sessions."""
