"""Choose the trajectory that tracking of a segment starts from."""
