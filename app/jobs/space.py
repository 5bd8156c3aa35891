"""One order to solve for the motion in space, stretch by stretch."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event

from keypose.app.jobs.failure import failure_message
from keypose.app.jobs.messages import JobFailed, JobFinished, Report, SpaceOrder, SpaceSolved
from keypose.tracker.session import Session

Send = Callable[[Report], None]

_FAULT = "Smoothing failed with an internal error ({}). The motion is as it was tracked."


def solve_order(order: SpaceOrder, cancelled: Event, send: Send) -> None:
    """Do the work and report every stretch, and how it ended."""
    from keypose.tracker.storage.space import solved  # loads what only this needs

    try:
        session = Session.model_validate_json(order.session)
        for stretch in order.stretches:
            found = solved(session, stretch, cancelled.is_set)
            if cancelled.is_set():
                break
            send(SpaceSolved(order.job, found))
    except Exception as error:  # noqa: BLE001 — a fault, reported as such
        send(JobFailed(order.job, failure_message(error, _FAULT)))
    else:
        send(JobFinished(order.job, cancelled=cancelled.is_set()))
