"""The motion for OpenSim: joint coordinates, and what fits a full-body model to our body."""
