"""Fit poses to observed surfaces: meshes of a moving thing, one per time step.

The method is that of surface fitting through contact and phantom volume, SURFACE in the comments.
"""
