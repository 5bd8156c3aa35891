"""Add what the picture shows besides brightness, as terms of a segment's solve."""
