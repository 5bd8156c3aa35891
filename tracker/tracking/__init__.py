"""Track the motion between keyframes: passes over frame pairs, drift correction, the best kept."""
