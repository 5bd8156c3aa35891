"""Serve the page: its port, its access control, and its routes."""
