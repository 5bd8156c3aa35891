"""How exact and how quick the tracker is: `python -m bench`."""
