"""Make surfaces from calibrated cameras: visual hulls, rated by photo-consistency."""
