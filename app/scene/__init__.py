"""What the four views of the page show, drawn by viser."""
