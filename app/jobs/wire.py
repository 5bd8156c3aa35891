"""Send messages as bytes between our own two processes, and a failure as one sentence."""

from __future__ import annotations

import io
import pickle
import sys
import traceback
from dataclasses import fields
from multiprocessing.connection import Connection
from typing import Any

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import KeyposeError
from keypose.tracker.tracking.result import Diagnostics, SegmentResult


def failure_message(
    error: Exception, fault: str = "Keypose ran into an internal error ({})."
) -> str:
    """The sentence of a KeyposeError; of any other error `fault` with its kind, and the traceback
    on stderr for the log."""
    if isinstance(error, KeyposeError):
        return str(error)
    traceback.print_exception(error, file=sys.stderr)
    return fault.format(type(error).__name__)


def send(connection: Connection, message: object) -> None:
    """Send a message; OSError when nobody is at the other end any more."""
    content = io.BytesIO()
    _Pickler(content, protocol=pickle.HIGHEST_PROTOCOL).dump(message)
    connection.send_bytes(content.getbuffer())


def receive(connection: Connection) -> Any:
    """Wait for a message; EOFError or OSError when there will be none."""
    return pickle.loads(connection.recv_bytes())


class _Pickler(pickle.Pickler):
    def reducer_override(self, it: Any) -> Any:
        """Poses and results are made anew from their fields, which makes their arrays read-only."""
        if isinstance(it, Pose | Trajectory | Diagnostics | SegmentResult):
            return type(it), tuple(getattr(it, field.name) for field in fields(it))
        return NotImplemented
