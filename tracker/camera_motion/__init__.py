"""Find how a film's camera turned and zoomed, from its background."""
