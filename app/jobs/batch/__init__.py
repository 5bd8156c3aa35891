"""Saved sessions tracked anew, many at a time, without a page."""
