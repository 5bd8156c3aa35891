"""The network that lifts keypoints into space: what it is trained on, its training, its measure."""
