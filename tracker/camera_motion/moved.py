"""Find where a film's camera went that moves through a place, from its background.

The scale is not told by pictures: the path's unit is the usual depth of points where the camera
began to move, until `metric.scale_from_stances` or a person says how long it is. The focal length
stays what it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.findings import Finding, gaps
from keypose.tracker.camera_motion.focal import FocalScale
from keypose.tracker.camera_motion.moving import MovingCamera
from keypose.tracker.camera_motion.path_drift import bridged
from keypose.tracker.camera_motion.points import Background, Grey
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class MovedPath:
    """A path in a unit of its own.

    pieces: first frames of what hangs together; after a cut the unit is another.
    moves: whether the film shows that the camera was elsewhere than at the first frame; else it
    is turned only.  known (N,): at which frames it is measured; elsewhere it is bridged.
    error_px (N,): median residual of the points that agree, pixels of the film, NaN where unknown.
    focal: the focal length that the first piece tells, where that was asked for.
    """

    path: CameraPath
    pieces: tuple[int, ...]
    moves: bool
    known: NDArray[np.bool_]
    error_px: Array
    findings: tuple[Finding, ...]
    focal: FocalScale | None = None

    def in_metres(self, *metres: float) -> CameraPath:
        """The path, where its unit is so many metres long: one number, or one for each piece."""
        each = metres * len(self.pieces) if len(metres) == 1 else metres
        if len(each) != len(self.pieces):
            raise ValueError(f"{len(metres)} lengths were given for {len(self.pieces)} pieces")
        return self.path.in_metres(self.pieces, each)


def find_moved_path(
    pictures: Iterable[Grey | None],
    camera: Camera,
    frame_count: int,
    background: Background = lambda frame: None,
    progress: Callable[[int, int], None] = lambda done, expected: None,
    *,
    with_focal: bool = False,
) -> MovedPath:
    """Follow the camera through the pictures (H, W) of a film, in order; None for one that cannot
    be read. No picture is kept.

    camera: its lens.  frame_count: how many pictures are expected.  progress(done, expected) after
    every frame; what it raises ends the work.  with_focal: whether to learn the focal length.
    """
    pieces = [MovingCamera(camera)]
    for frame, picture in enumerate(pictures):
        usable = background(frame)
        pieces[-1].take(picture, usable)
        if pieces[-1].ended:
            pieces[-1].drop_last()
            pieces.append(MovingCamera(camera))
            pieces[-1].take(picture, usable)
        progress(frame + 1, max(frame_count, frame + 1))
    path = _joined(pieces)
    return replace(path, focal=pieces[0].focal()) if with_focal else path


def _joined(pieces: Sequence[MovingCamera]) -> MovedPath:
    """All pieces, each from where the one before ended."""
    causes = [cause for piece in pieces for cause in piece.causes]
    known = np.array([not cause for cause in causes], bool)
    Ts = [np.zeros((0, 4, 4))]
    for piece in pieces:
        start = Ts[-1][-1] if len(Ts[-1]) else np.eye(4)
        if piece.causes:
            found = np.array([not cause for cause in piece.causes], bool)
            Ts.append(bridged(piece.finished(), found) @ start)
    starts = np.cumsum([0, *(len(piece.causes) for piece in pieces)]).tolist()
    findings = gaps(causes)
    findings += [Finding("cut", first, first, 1.0) for first in starts[1:-1]]
    findings += [
        Finding("no_parallax", first, beyond - 1, 1.0)
        for piece, (first, beyond) in zip(pieces, pairwise(starts), strict=True)
        if beyond > first and not piece.known
    ]
    errors = np.array([error for piece in pieces for error in piece.errors_px])
    return MovedPath(
        CameraPath(np.concatenate(Ts), np.ones(len(causes))),
        tuple(starts[:-1]),
        any(piece.known for piece in pieces),
        known,
        np.where(known, errors, np.nan),
        tuple(sorted(findings, key=lambda finding: finding.first_frame)),
    )
