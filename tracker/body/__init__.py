"""Describe the articulated body: parts, poses, trajectories, and operations on its solids."""
