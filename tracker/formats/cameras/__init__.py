"""Read a camera as another program or this one wrote it, a module for each kind of file."""
