"""Detect a body's keypoints frame by frame with a network, and find outliers among them."""
