"""The codes that commands end with."""

from __future__ import annotations

DONE = 0
NOT_ALL_DONE = 1
"""Tracking was lost somewhere, a step of several could not be done, or nothing was found."""
BAD_INPUT = 2
"""Said in one sentence."""
FAULT = 70
"""A fault of Keypose itself, with a traceback."""
INTERRUPTED = 130
NO_READER = 141
"""Nobody reads the output any more."""
