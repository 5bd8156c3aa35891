"""Several films of one motion: their clocks, and where their cameras are, from the body itself."""
