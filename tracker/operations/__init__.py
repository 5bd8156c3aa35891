"""Do what changes a session: track, stand, solve in space, find the camera, find up."""
