"""Run the commands, one module each: `add` describes its arguments, `run` does it.

What a command needs of the tracker is imported when it runs, so that `keypose --help` is quick.
"""
