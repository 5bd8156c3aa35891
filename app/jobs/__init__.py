"""Track and fit in a worker process, so that the page stays quick."""
