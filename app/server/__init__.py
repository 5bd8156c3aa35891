"""The server of the page: its port, its door, and what is to be had behind it."""
