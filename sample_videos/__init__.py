"""Clips to try the product on, with the exact motion they show."""
