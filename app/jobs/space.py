"""Solve for the motion in space of stretches that were tracked before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from keypose.app.jobs.job import Context, Job
from keypose.app.words.jobs import spans_text
from keypose.tracker.session import Session
from keypose.tracker.storage.stretches import SegmentRun


@dataclass(frozen=True, eq=False)
class SolveSpace(Job):
    """session: JSON of a session with its keyframes and pins."""

    session: bytes
    stretches: tuple[SegmentRun, ...]

    kind = "space"
    fault = "Smoothing failed with an internal error ({}). The motion is as it was tracked."
    failed = "Smoothing failed"
    died = "Smoothing stopped unexpectedly; the motion is as it was tracked."

    @classmethod
    def of(cls, session: Session, stretches: Sequence[SegmentRun]) -> Self:
        content = session.changed({"drafts": (), "results": None}).model_dump_json()
        return cls(content.encode(), tuple(stretches))

    @property
    def title(self) -> str:
        return f"Smoothing {spans_text([stretch.span for stretch in self.stretches])}"

    def run(self, context: Context) -> None:
        from keypose.tracker.operations.solve_space import solved  # loads what only this needs

        session = Session.model_validate_json(self.session)
        for done, stretch in enumerate(self.stretches, 1):
            space_result = solved(session, stretch, context.cancelled)
            context.leave_when_cancelled()
            context.report(done / len(self.stretches), partial=space_result)
