"""What a detector sees of one body, frame by frame."""
