"""Rotations, rigid transforms, cameras."""
