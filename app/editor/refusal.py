"""An action that cannot be done, in one sentence."""

from __future__ import annotations

from keypose.tracker.errors import KeyposeError


class Refused(KeyposeError):
    """What was asked for is not possible now; the state stays as it is."""
