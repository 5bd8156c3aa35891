"""Meshes out of foreign files: numbered steps, read in a process of its own, checked twice."""
