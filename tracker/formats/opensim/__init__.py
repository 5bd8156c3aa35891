"""Write the motion in the coordinates of OpenSim, and fit a full-body model to our body."""
