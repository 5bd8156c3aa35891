"""The method: from keyframes and pictures to the motion between them."""
