"""The server of the page: its port, its access control, and what it serves."""
