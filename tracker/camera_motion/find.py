"""Find how a film's camera turned and zoomed, or where it went, from its background."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.findings import (
    Finding,
    are_faded,
    contrast_of,
    gaps,
    scenes,
)
from keypose.tracker.camera_motion.focal import FocalScale, focal_scale
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.measurements import FollowedPoints, Measurements
from keypose.tracker.camera_motion.moving_odometry import MovingOdometry
from keypose.tracker.camera_motion.path import Turns, poses_bridged
from keypose.tracker.camera_motion.points import Background, Grey
from keypose.tracker.camera_motion.shutter import Shutter
from keypose.tracker.camera_motion.steadiness import Summary
from keypose.tracker.camera_motion.turning_odometry import TurningOdometry
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array

CameraKind: TypeAlias = Literal["static", "turns", "moves"]

STILL_PX = 0.35
"""A camera is static where no part of the picture went farther, of the size looked at."""
NO_ZOOM = 0.002
"""Logarithm of a zoom that is none."""
ZOOM_SIGMAS = 3.0
"""Standard deviations within which a zoom is none."""
ASIDE_SHARE = 0.35
"""Share of points beside where a turning camera would show them, above which it moves."""
AGREEING_SHARE = 0.73
"""Share of the points that must move alike, in the middle frame, or that is reported."""
STILL_ASIDE_SHARE = 0.6
"""The same where all others stand still: something large then moves before a static camera."""


@dataclass(frozen=True, eq=False)
class CameraMotion:
    """The camera's motion as a film shows it.

    kind: "static", "turns" (and zooms), or "moves": then `path` is the turning that explains most.
    path: None for a static camera.  known (N,): at which frames it is measured; elsewhere it is
    bridged.  error_px (N,): median residual of the points that agree, pixels of the film, NaN
    where unknown.  focal: the focal length by its turning, None where that is not observable.
    pieces: first frames of what hangs together; nothing ties one to those before it.
    """

    kind: CameraKind
    path: CameraPath | None
    known: NDArray[np.bool_]
    error_px: Array
    points: FollowedPoints
    findings: tuple[Finding, ...]
    focal: FocalScale | None = None
    pieces: tuple[int, ...] = (0,)


def find_camera_motion(
    pictures: Iterable[Grey | None],
    camera: Camera,
    frame_count: int,
    background: Background = lambda frame: None,
    fixed: CameraKind | None = None,
    progress: Callable[[int, int], None] = lambda done, expected: None,
) -> CameraMotion:
    """Find how a camera turned and zoomed, or that it moves, from the background of its film.

    Args:
        pictures: (H, W) of the film, in order; None for one that cannot be read.
        camera: its lens at zoom 1.
        frame_count: how many pictures are expected.
        background: of a frame, the pixels (H, W) that may be background; None for all.
        fixed: the kind, where it is known.
        progress: receives (done, expected) after every frame; what it raises ends the work.

    Raises:
        CameraError: where a picture has not the camera's size.
    """
    odometry, measured = TurningOdometry(Lens.of(camera)), Measurements()
    contrasts: list[float] = []
    for frame, picture in enumerate(pictures):
        _require_size(picture, camera)
        contrasts.append(np.nan if picture is None else contrast_of(picture))
        measured.add(odometry.advance(frame, picture, background(frame)))
        progress(frame + 1, max(frame_count, frame + 1))
    odometry.finish()
    if not len(measured):
        none = np.zeros(0)
        return CameraMotion("static", None, none > 0, none, measured.points(), ())
    is_known, cuts, pieces = scenes(
        measured.keyframe, measured.known, odometry.untied, odometry.cuts
    )
    keyframes, readout = odometry.map.optimised(), odometry.shutter.share
    turns = measured.turns(is_known, keyframes, odometry.map.frames, readout)
    turns = _without_zoom(turns.bridged())
    focal = focal_scale(odometry.lens, odometry.scale, odometry.pairs)
    kind = fixed or _kind(turns, camera, odometry, focal)
    path = None if kind == "static" else turns.path()
    error_px = np.where(is_known, measured.error_px, np.nan)
    faded = are_faded(np.array(contrasts))
    findings = tuple(_findings(measured, cuts, is_known, kind, odometry.shutter, faded))
    points = measured.points()
    return CameraMotion(kind, path, is_known, error_px, points, findings, focal, pieces)


def _require_size(picture: Grey | None, camera: Camera) -> None:
    if picture is not None and picture.shape != (camera.height, camera.width):
        raise CameraError(
            f"The film's pictures are not of the camera's size, {camera.width}×{camera.height}: "
            "choose the camera that took it."
        )


def _without_zoom(turns: Turns) -> Turns:
    """The same with no zoom at all, where it differs from none by no more than its noise."""
    most = np.maximum(NO_ZOOM, ZOOM_SIGMAS * turns.zoom_doubt)
    if (np.abs(turns.log_zoom)[turns.known] > most[turns.known]).any():
        return turns
    return Turns(turns.R, 0.0 * turns.log_zoom, turns.known, turns.doubt, turns.zoom_doubt)


def _kind(
    turns: Turns, camera: Camera, odometry: TurningOdometry, focal: FocalScale | None
) -> CameraKind:
    """How the camera moves, by how far its turning went and by the points that it leaves aside.

    Args:
        turns: of all frames.
        camera: its lens.
        odometry: that measured them.
        focal: the focal length by the turns; None where that is not observable.
    """
    # a wrong focal length leaves points aside as well
    aside = min(_aside(odometry.summaries), 1.0 if focal is None else focal.aside)
    ways_px = _ways(turns, camera) * odometry.scale
    if ways_px[turns.known].max(initial=0.0) < STILL_PX and aside < STILL_ASIDE_SHARE:
        return "static"
    return "moves" if aside > ASIDE_SHARE else "turns"


def _aside(summaries: Sequence[Summary]) -> float:
    """The share of points that do not stay where a turning camera would show them."""
    points = np.array([s.points for s in summaries], float)
    aside = np.array([s.aside for s in summaries])
    return float((points * aside).sum() / max(points.sum(), 1.0))


def _ways(turns: Turns, camera: Camera) -> Array:
    """How far (N,) the middle part of the picture has gone since the first frame, at most, film's
    pixels.
    """
    lens, share = Lens.of(camera), np.array([0.25, 0.5, 0.75])
    grid = np.stack(np.meshgrid(share * camera.width, share * camera.height), -1).reshape(-1, 2)
    rays = lens.directions(grid, 1.0)
    turned = np.einsum("nab,kb->nka", turns.R, rays)
    z = turned[..., 2:]
    ahead = z > 1e-3
    flat = np.exp(turns.log_zoom)[:, None, None] * turned[..., :2] / np.where(ahead, z, 1)
    ways_px = np.where(ahead, flat - rays[:, :2] / rays[:, 2:], np.inf) * lens.focal_px
    return np.asarray(np.linalg.norm(ways_px, axis=-1).max(axis=1))


def _findings(
    measured: Measurements,
    cuts: Sequence[int],
    is_known: NDArray[np.bool_],
    kind: CameraKind,
    shutter: Shutter,
    faded: NDArray[np.bool_],
) -> list[Finding]:
    """What is doubtful, in the order of frames.

    Args:
        measured: all frames.
        cuts: first frames after a cut.
        is_known: (N,) at which frames the camera is known.
        kind: how it moves.
        shutter: what was learned of its readout.
        faded: (N,) which pictures are faint, or fade.
    """
    causes = [
        "" if k else c or "no_texture" for c, k in zip(measured.causes, is_known, strict=True)
    ]
    causes = [
        "no_texture" if f and c == "not_rigid" else c for c, f in zip(causes, faded, strict=True)
    ]
    findings = gaps(causes)
    findings += [Finding("cut", frame, frame, 1.0) for frame in cuts]
    last = len(measured) - 1
    shares = measured.share[is_known]
    if kind != "moves" and len(shares) and (share := float(np.median(shares))) < AGREEING_SHARE:
        findings.append(Finding("not_rigid", 0, last, 1 - share))
    readout = shutter.reported()
    if kind != "static" and readout is not None:
        findings.append(Finding("rolling_shutter", 0, last, readout if kind == "turns" else 0.0))
    return sorted(findings, key=lambda finding: finding.first_frame)


# --- a camera that moves


@dataclass(frozen=True, eq=False)
class MovedPath:
    """The path of a camera that moves, in a unit of its own: the usual depth of points where it
    began to move, until `metric` or a person says how long that is.

    pieces: first frames of what hangs together; after a cut the unit is another.
    moves: whether the film shows that the camera was elsewhere than at the first frame; else it
    is turned only.  known (N,): at which frames it is measured; elsewhere it is bridged.
    error_px (N,): median residual of the points that agree, pixels of the film, NaN where unknown.
    focal: the focal length by the first piece, where that was asked for.
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
    """Find where a camera went that moves, from the background of its film. No picture is kept.

    Args:
        pictures: (H, W) of the film, in order; None for one that cannot be read.
        camera: its lens, whose focal length stays what it is.
        frame_count: how many pictures are expected.
        background: of a frame, the pixels (H, W) that may be background; None for all.
        progress: receives (done, expected) after every frame; what it raises ends the work.
        with_focal: whether to learn the focal length.
    """
    pieces = [MovingOdometry(camera)]
    for frame, picture in enumerate(pictures):
        usable = background(frame)
        pieces[-1].take(picture, usable)
        if pieces[-1].ended:
            pieces[-1].drop_last()
            pieces.append(MovingOdometry(camera))
            pieces[-1].take(picture, usable)
        progress(frame + 1, max(frame_count, frame + 1))
    path = _joined(pieces)
    return replace(path, focal=pieces[0].focal()) if with_focal else path


def _joined(pieces: Sequence[MovingOdometry]) -> MovedPath:
    """All pieces, each from where the one before ended."""
    causes = [cause for piece in pieces for cause in piece.causes]
    known = np.array([not cause for cause in causes], bool)
    Ts = [np.zeros((0, 4, 4))]
    for piece in pieces:
        start = Ts[-1][-1] if len(Ts[-1]) else np.eye(4)
        if piece.causes:
            is_known = np.array([not cause for cause in piece.causes], bool)
            Ts.append(poses_bridged(piece.finished(), is_known) @ start)
    starts = np.cumsum([0, *(len(piece.causes) for piece in pieces)]).tolist()
    findings = gaps(causes)
    findings += [Finding("cut", first, first, 1.0) for first in starts[1:-1]]
    findings += [
        Finding("no_parallax", first, beyond - 1, 1.0)
        for piece, (first, beyond) in zip(pieces, pairwise(starts), strict=True)
        if beyond > first and not piece.has_depths
    ]
    errors = np.array([error for piece in pieces for error in piece.errors_px])
    return MovedPath(
        CameraPath(np.concatenate(Ts), np.ones(len(causes))),
        tuple(starts[:-1]),
        any(piece.has_depths for piece in pieces),
        known,
        np.where(known, errors, np.nan),
        tuple(sorted(findings, key=lambda finding: finding.first_frame)),
    )
