"""Track many saved sessions anew, without a page."""
