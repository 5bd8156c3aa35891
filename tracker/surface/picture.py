"""Observed surfaces as a video: frame i is the surface of step i, seen by the session's camera.

So all that shows frames shows surfaces. A step that cannot be used is a frame that is missing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.references import Surface
from keypose.tracker.session.schema import Session
from keypose.tracker.surface.painting import Picture, paint
from keypose.tracker.surface.source import SurfaceSteps, open_steps
from keypose.tracker.video.damage import Examined
from keypose.tracker.video.info import MissingFrame, VideoInfo
from keypose.tracker.video.video import Video

CONTAINER = "surfaces"
"""The kind of file, as reported."""


class SurfaceSource:
    """Draws the steps of surfaces as pictures of one camera."""

    def __init__(self, steps: SurfaceSteps, camera: Camera, fps: float) -> None:
        self.steps, self._camera = steps, camera
        self._problems = dict(steps.sequence.missing)
        self._facts = _facts(steps, camera, fps, self._problems)

    @property
    def info(self) -> VideoInfo:
        return self._facts

    def approach(self, number: int, since: int) -> Iterator[tuple[int, Picture]]:
        """Gives frame `number`, or nothing when its surface cannot be used."""
        try:
            yield number, paint(self.steps.shape(number), self._camera)
        except SurfaceError as error:
            self._problems[number] = str(error)
            self._facts = replace(self._facts, missing=tuple(sorted(self._problems)))

    def problem(self, number: int) -> str:
        """Why a missing frame is missing."""
        return self._problems.get(number, f"The mesh of frame {number} cannot be used.")

    def reindex(self) -> None:
        """The steps are counted once."""

    def examine(self, first: int, last: int) -> Iterator[Examined]:
        """Frames are independent: none is damaged by another."""
        yield Examined(first, last, frozenset(), last)

    def fingerprint(self) -> str:
        return self.steps.sequence.fingerprint()

    def close(self) -> None:
        self.steps.close()


class SurfaceVideo(Video):
    """The pictures of surfaces; `steps` has the surfaces themselves."""

    def __init__(self, source: SurfaceSource) -> None:
        super().__init__(source)
        self._drawn = source

    @property
    def steps(self) -> SurfaceSteps:
        """The surfaces in the camera frame, metres."""
        return self._drawn.steps

    def frame(self, index: int, shrink: int = 1) -> Picture:
        """A frame as Video.frame; MissingFrame says what is wrong with the step's mesh."""
        try:
            return super().frame(index, shrink)
        except MissingFrame:
            words = self._drawn.problem(index)
            raise MissingFrame(words, words) from None

    def note(self, index: int) -> str | None:
        """The note as Video.note."""
        return self.steps.sequence.missing.get(index)


def open_surfaces(session: Session, meshes: Path, folder: Path) -> SurfaceVideo:
    """The surfaces of a session at a path; `folder` is that of the session's file.

    SurfaceError in one sentence where meshes or cameras cannot be used.
    """
    assert session.view.surface is not None
    steps = open_steps(session.view.surface, meshes, folder)
    return surface_video(steps, session.view.surface, session.view.camera)


def surface_video(steps: SurfaceSteps, surface: Surface, camera: Camera) -> SurfaceVideo:
    """Surfaces that are open already, as a video."""
    return SurfaceVideo(SurfaceSource(steps, camera.without_distortion(), surface.fps))


def _facts(steps: SurfaceSteps, camera: Camera, fps: float, missing: dict[int, str]) -> VideoInfo:
    rate = Fraction(fps).limit_denominator(100_000)
    pts = np.arange(steps.frame_count, dtype=np.int64)
    times_s = pts / float(rate)
    for array in (pts, times_s):
        array.setflags(write=False)
    return VideoInfo(
        path=steps.sequence.path,
        container=CONTAINER,
        codec="meshes",
        width=camera.width,
        height=camera.height,
        frame_count=steps.frame_count,
        time_base=1 / rate,
        pts=pts,
        times_s=times_s,
        fps=float(rate),
        variable_rate=False,
        rotation_deg=0,
        interlaced=False,
        pixel_aspect=Fraction(1),
        missing=tuple(sorted(missing)),
    )
