"""The ways to use Keypose: the command line and its pictures."""
