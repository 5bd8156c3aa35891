"""Have the worker do what was asked for, and what follows by itself, one job at a time."""
