"""Compute with rotations, rigid transforms and cameras."""
