"""Documents: sessions created, opened, saved and listed."""
