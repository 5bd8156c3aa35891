"""Hold what the page shows, as plain frozen values."""
