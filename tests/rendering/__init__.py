"""Video sequences whose truth is known exactly: bodies, motions, and a renderer of our own."""
