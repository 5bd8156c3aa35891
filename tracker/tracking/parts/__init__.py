"""Correct a tracked segment where limbs alone were posed between its keyframes."""
