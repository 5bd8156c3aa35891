"""The articulated body: parts, poses, trajectories, and what is made of its solids."""
