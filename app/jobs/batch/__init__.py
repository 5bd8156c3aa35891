"""Track many saved sessions, or make them of films, without a page."""
