"""Declare the arguments of the commands; what does them is loaded when it is called."""
