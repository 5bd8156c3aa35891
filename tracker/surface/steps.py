"""Where observed surfaces come from, as the fit sees it."""

from __future__ import annotations

from typing import Protocol

from keypose.tracker.surface.mesh import SurfaceMesh


class Steps(Protocol):
    """The surfaces of a moving thing, one for each step of time."""

    @property
    def frame_count(self) -> int: ...

    def mesh(self, frame: int) -> SurfaceMesh:
        """The surface of a step in the camera frame, metres.

        SurfaceError in one sentence where that step cannot be used; the others can.
        """
        ...

    def cut_by(self, frame: int) -> tuple[str, ...]:
        """Names of the cameras whose pictures do not hold all of a step's surface."""
        ...
