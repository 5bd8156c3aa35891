"""What a person reads when something fails."""

from __future__ import annotations

import sys
import traceback

from keypose.tracker.errors import KeyposeError


def failure_message(
    error: Exception, fault: str = "Keypose ran into an internal error ({})."
) -> str:
    """The sentence of a KeyposeError; of any other error `fault` with its kind, and the traceback
    on stderr for the log."""
    if isinstance(error, KeyposeError):
        return str(error)
    traceback.print_exception(error, file=sys.stderr)
    return fault.format(type(error).__name__)
