"""Draw what the four views of the page show, by viser."""
