"""Where tracking of a segment starts from."""
