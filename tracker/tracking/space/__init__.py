"""The motion in space: one last solve over neighbouring segments, and what is measured of it."""
