"""Find the motion of a session's camera from the background of its film."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.camera_motion import (
    CameraKind,
    Finding,
    FollowedPoints,
    MovedPath,
    PathScale,
    StandingPoint,
    find_camera_motion,
    find_moved_path,
    scale_from_stances,
)
from keypose.tracker.camera_motion import (
    CameraMotion as TurnedCamera,
)
from keypose.tracker.camera_motion.background import BodyBackground
from keypose.tracker.camera_motion.metric import scale_from_smoothness
from keypose.tracker.errors import CameraError
from keypose.tracker.files import read_own
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.keypoints.model_files import cache_folder
from keypose.tracker.operations.solve_space import frames_per_second
from keypose.tracker.session.camera_motion import (
    CameraFinding,
    CameraKeyframe,
    CameraMotion,
    CameraPiece,
    path_through,
)
from keypose.tracker.session.pins import Pin, pins_within
from keypose.tracker.session.schema import Session
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.storage.archive import archive_arrays, archive_bytes
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.fingerprints import Span, steady_camera, turns_of
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize

PASS_SHARE: Final = 0.5
"""Of the work that is left, each reading of the film but the last."""
MOST_LENSES: Final = 3
"""Focal lengths with which a film is looked at, where that is a guess."""
SURE: Final = 3.0
"""Standard deviations by which the focal length estimated from the motion has to differ."""
LEAST_OFF: Final = 0.01
"""A focal length that is off by less stays."""
LEAST_GAIN: Final = 0.8
"""Share of the error with a guessed lens that one estimated from the motion may leave."""
MOST_KEPT: Final = 40
"""Films whose points are kept."""
LARGEST_BYTES: Final = 2**30


Found = TypeVar("Found", TurnedCamera, MovedPath)


@dataclass(frozen=True, eq=False)
class FoundCamera:
    """What was found of a session's camera.

    motion: None where it stands still.  points: of the background, good and refused; None once they
        are kept.  findings: of all that is doubtful.  focal: the focal length estimated from its
        turns, as a share of the camera's, and the standard deviation; None where it is not known.
    lens: the camera as estimated from its motion, where its focal length was a guess and is off;
        else None.
    """

    kind: CameraKind
    motion: CameraMotion | None
    points: FollowedPoints | None
    findings: tuple[CameraFinding, ...]
    focal: tuple[float, float] | None
    lens: Camera | None = None

    def applied(self, session: Session) -> Session:
        """The session with this motion of its camera; whether that stands still is as found. How a
        person corrected its turns stays, as long as it moves."""
        before = session.view.camera_motion
        keys = () if self.motion is None else session.view.camera_keyframes
        if self.motion is not None and before is not None:
            keys = _kept_on_path(keys, before, self.motion)
        video = session.view.video.model_copy(update={"stands_still": self.kind == "static"})
        settings = session.settings.model_copy(update={"static_camera": None})
        fields = {"video": video, "settings": settings, "camera_keyframes": keys}
        return session.changed({"camera_motion": self.motion, **fields})


def find_camera(
    session: Session,
    video: Video,
    poses: Mapping[int, Pose],
    kind: CameraKind | None = None,
    report: Callable[[float], None] = lambda share: None,
) -> FoundCamera:
    """Find how the camera of a session's film moves.

    poses: of the body where it is known, by frame: it is no background.  kind: where it is known
    how the camera moves.  report: receives the share that is done; what it raises ends the work.
    """
    film = _Film(session, video, poses, report)
    camera_before = session.view.camera
    camera, camera_found = camera_before, film.turned(camera_before, kind)
    if session.view.lens_is_guess:
        camera, camera_found = _with_its_lens(
            camera,
            camera_found,
            lambda other_lens: film.turned(other_lens, kind),
            lambda camera_motion: camera_motion.kind == "turns",
        )
    focal = (
        None if camera_found.focal is None else (camera_found.focal.scale, camera_found.focal.sigma)
    )
    findings = tuple(map(_finding, camera_found.findings))
    if camera_found.path is None or camera_found.kind == "static":
        return FoundCamera("static", None, camera_found.points, findings, focal)
    motion = None
    if camera_found.kind == "moves":
        moved = film.moved(camera)
        if session.view.lens_is_guess:
            camera, moved = _with_its_lens(
                camera, moved, film.moved, lambda moved_path: moved_path.moves
            )
        if moved.moves:
            rolling = (
                camera_finding
                for camera_finding in findings
                if camera_finding.kind == "rolling_shutter"
            )
            findings = (*map(_finding, moved.findings), *rolling)
            pieces = tuple(CameraPiece(first_frame=each, metres=None) for each in moved.pieces)
            motion = CameraMotion.of("moves", moved.path, moved.error_px, findings, pieces=pieces)
        elif kind == "moves":
            last = session.view.video.frame_count - 1
            findings += (CameraFinding(kind="no_parallax", first_frame=0, last_frame=last),)
    if motion is None:
        pieces = tuple(CameraPiece(first_frame=each) for each in camera_found.pieces)
        motion = CameraMotion.of(
            "turns", camera_found.path, camera_found.error_px, findings, pieces=pieces
        )
    lens = None if camera is camera_before else camera
    return FoundCamera(motion.kind, motion, camera_found.points, findings, focal, lens)


@dataclass(eq=False)
class _Film:
    """The pictures of a film, read once for every pass over them, and what of them is background.

    done: the share of the work that is done, as far as anybody knows how many passes there will be.
    """

    session: Session
    video: Video
    poses: Mapping[int, Pose]
    report: Callable[[float], None]
    done: float = 0.0

    @cached_property
    def background(self) -> BodyBackground:
        view, skeleton = self.session.view, Skeleton.of(self.session.subject.body)
        path = self.session.camera_path
        zoom = None if path is None else path.zoom
        return BodyBackground(skeleton, view.camera, self.poses, view.ignore_masks, zoom)

    @property
    def frame_count(self) -> int:
        return self.session.view.video.frame_count

    def turned(self, camera: Camera, kind: CameraKind | None) -> TurnedCamera:
        """How the camera turned, were this its lens."""
        return find_camera_motion(
            _greys(self.video),
            camera,
            self.frame_count,
            self.background,
            kind,
            self._pass(PASS_SHARE),
        )

    def moved(self, camera: Camera) -> MovedPath:
        """Where the camera went."""
        is_guess = self.session.view.lens_is_guess
        return find_moved_path(
            _greys(self.video),
            camera,
            self.frame_count,
            self.background,
            self._pass(PASS_SHARE if is_guess else 1.0),
            with_focal=is_guess,
        )

    def _pass(self, share: float) -> Callable[[int, int], None]:
        """Report of a pass that takes a share of what is left."""
        start, length = self.done, share * (1 - self.done)
        self.done = start + length
        return lambda done, expected: self.report(start + length * done / expected)


def _with_its_lens(
    camera: Camera,
    first: Found,
    again: Callable[[Camera], Found],
    is_sound: Callable[[Found], bool],
) -> tuple[Camera, Found]:
    """The camera and its motion, with the focal length that the motion itself tells, where that is
    another one for sure and the background agrees better with it."""
    latest, best = first, (camera, first)
    for _ in range(MOST_LENSES - 1):
        focal = latest.focal
        if focal is None or abs(np.log(focal.scale)) < max(SURE * focal.sigma, LEAST_OFF):
            break
        camera = camera.zoomed(focal.scale)
        latest = again(camera)
        if is_sound(latest) and _error(latest) < LEAST_GAIN * _error(first):
            best = camera, latest
    return best


def _error(camera_found: Found) -> float:
    """The usual error of the background's points, pixels; infinite where there is none."""
    known_px = camera_found.error_px[np.isfinite(camera_found.error_px)]
    return float(np.median(known_px)) if known_px.size else np.inf


def _finding(finding: Finding) -> CameraFinding:
    return CameraFinding(
        kind=finding.kind,
        first_frame=finding.first_frame,
        last_frame=finding.last_frame,
        amount=float(finding.amount),
    )


def with_scale(session: Session, fitting: Mapping[Span, SegmentResult]) -> Session:
    """The session with the scale of its camera's way where that is not known, piece by piece, as
    feet that stand and the body's own motion tell it; itself where nothing does.

    fitting: what was tracked, by segment.
    """
    motion = session.view.camera_motion
    if motion is None or not motion.unscaled or session.camera_path is None:
        return session
    path, runs, pieces = motion.in_its_units, list(_runs(fitting)), list(motion.pieces)
    for number, (piece, span) in enumerate(zip(motion.pieces, motion.spans, strict=True)):
        within = [_within(run, span) for run in runs if run.first_frame < span[1]]
        if piece.metres is not None:
            continue
        path_scale = _scale(session, path, [run for run in within if len(run) > 1])
        if path_scale is not None:
            pieces[number] = piece.model_copy(
                update={
                    "metres": float(f"{path_scale.metres:.7g}"),
                    "sigma": float(f"{path_scale.sd / path_scale.metres:.3g}"),
                }
            )
    if tuple(pieces) == motion.pieces:
        return session
    return _with_motion(session, motion.model_copy(update={"pieces": tuple(pieces)}))


def with_known_way(session: Session, first_frame: int, farthest_m: float) -> Session:
    """The session whose camera went so far from where it was at a frame at which a piece of its
    motion begins. CameraError in one sentence where it went nowhere."""
    motion = session.view.camera_motion
    if session.has_static_camera:
        raise CameraError("The camera stands still: its path has no length.")
    if motion is None:
        raise CameraError("Nothing is known of the camera's motion: find it first.")
    if motion.kind != "moves":
        raise CameraError("The camera turns and goes nowhere: its path has no length.")
    try:
        return _with_motion(session, motion.with_way(first_frame, farthest_m))
    except ValueError as error:
        raise CameraError(str(error)) from None


def _with_motion(session: Session, motion: CameraMotion) -> Session:
    """The session with its camera's motion in another scale. Corrections stay beside the path."""
    before = session.view.camera_motion
    assert before is not None
    keys = _kept_on_path(session.view.camera_keyframes, before, motion)
    return session.changed({"camera_motion": motion, "camera_keyframes": keys})


def _kept_on_path(
    keys: Sequence[CameraKeyframe], motion: CameraMotion, other: CameraMotion
) -> tuple[CameraKeyframe, ...]:
    """Corrections of a camera's motion as those of another one of the same film: turned as they
    are, and beside the path as they were, which is on it where a person turned the camera alone."""
    kept: list[CameraKeyframe] = []
    for number, key in enumerate(keys):
        was, becomes = (
            path_through(camera_motion, tuple(before)).Ts_world_camera[key.frame, :3, 3]
            for camera_motion, before in ((motion, keys[:number]), (other, kept))
        )
        T = key.correction.T_camera_world.copy()
        T[:3, 3] -= T[:3, :3] @ (becomes - was)
        kept.append(CameraKeyframe.of(key.frame, T, key.zoom))
    return tuple(kept)


def _within(run: Trajectory, span: Span) -> Trajectory:
    """A motion's frames within a span, none where it has none."""
    first, last = max(run.first_frame, span[0]), min(run.last_frame, span[1])
    rows = slice(first - run.first_frame, max(last + 1, first) - run.first_frame)
    return Trajectory(first, run.Rs_parent_part[rows], run.ps_camera_root[rows])


def scaled(
    found_camera: FoundCamera, session: Session, fitting: Mapping[Span, SegmentResult]
) -> FoundCamera:
    """What was found of a session's camera, with its scale as `with_scale`."""
    motion = with_scale(found_camera.applied(session), fitting).view.camera_motion
    return replace(found_camera, motion=motion)


def _scale(session: Session, path: CameraPath, runs: Sequence[Trajectory]) -> PathScale | None:
    """By feet that stand; these are found with the scale that leaves the body least acceleration,
    where none are pinned."""
    skeleton, body = Skeleton.of(session.subject.body), session.subject.body
    smooth = [scale_from_smoothness(path, run.first_frame, run.ps_camera_root) for run in runs]
    usual = min(
        (one for one in smooth if one is not None),
        key=lambda path_scale: path_scale.sd,
        default=None,
    )
    standing = []
    for run in runs:
        Ts = run.transforms(skeleton)
        pins = [pin for pin in pins_within(session.subject.pins, _span(run)) if pin.landmarks]
        if not pins and usual is not None:
            pins = _still(session, skeleton, run, path, usual.metres)
        for pin in pins:
            rows = slice(pin.first_frame - run.first_frame, pin.last_frame + 1 - run.first_frame)
            T, points = Ts[rows, body.index(pin.part)], np.array(pin.points(body)).mean(axis=0)
            standing.append(StandingPoint(pin.first_frame, T[:, :3, :3] @ points + T[:, :3, 3]))
    return scale_from_stances(path, standing) or usual


def _still(
    session: Session, skeleton: Skeleton, run: Trajectory, path: CameraPath, metres: float
) -> list[Pin]:
    """Where feet stand still in the world, were the path's unit so long."""
    Ts = path.between(*_span(run)).Ts_world_camera.copy()
    Ts[:, :3, 3] *= metres
    rate = frames_per_second(session, run)
    pins = proposed_pins(skeleton, run.carried(Ts), rate, None, Ts[:, :3, 3])
    return [pin for pin in pins if len(pin.landmarks) > 1]


def _span(run: Trajectory) -> Span:
    return run.first_frame, run.last_frame


def _runs(fitting: Mapping[Span, SegmentResult]) -> Iterator[Trajectory]:
    """Neighbouring segments that are tracked, joined, before any solve in space."""
    run: list[Trajectory] = []
    for segment_result in (fitting[span].as_tracked for span in sorted(fitting)):
        if segment_result.missing or not segment_result.finished:
            continue
        if run and run[-1].last_frame != segment_result.first:
            yield joined(run)
            run = []
        run.append(segment_result.trajectory)
    if run:
        yield joined(run)


def keep_points(found_camera: FoundCamera, folder: Path | None = None) -> None:
    """Keep the points that a motion was found by in this user's cache folder, if that can be
    done: they are only looked at, and can be found again."""
    if found_camera.motion is None or found_camera.points is None:
        return
    place = _points_place(found_camera.motion, folder)
    content = archive_bytes(
        {
            "uv": found_camera.points.uv,
            "good": found_camera.points.good,
            "starts": found_camera.points.starts,
        }
    )
    with suppress(CameraError):
        make_folder(place.parent, error=CameraError)
        write_file(place, content, overwrite=True, error=CameraError)
    with suppress(OSError):
        for old in sorted(place.parent.glob("*.npz"), key=lambda f: f.stat().st_mtime)[:-MOST_KEPT]:
            old.unlink()


def points_of(motion: CameraMotion, folder: Path | None = None) -> FollowedPoints | None:
    """The points that a motion was found by; None where nobody kept them."""
    try:
        arrays = archive_arrays(read_own(_points_place(motion, folder), LARGEST_BYTES))
        uv, good, starts = (arrays[name] for name in ("uv", "good", "starts"))
        ends = int(starts[-1])
    except (OSError, ValueError, LookupError):
        return None
    if uv.shape != (ends, 2) or good.shape != (ends,) or len(starts) != motion.frame_count + 1:
        return None
    return FollowedPoints(uv, good, starts)


def _points_place(motion: CameraMotion, folder: Path | None) -> Path:
    name = hashlib.sha256(motion.samples.encode()).hexdigest()[:32]
    return (cache_folder() / "background" if folder is None else folder) / f"{name}.npz"


def background_picture(session: Session, video: Video) -> NDArray[np.uint8]:
    """Put together the empty scene all around a camera that turns: (h, w, 3) RGB, longitudes across
    and latitudes down, black where it is not known; of about the size that the film is tracked at.
    CameraError where the camera does not turn.
    """
    motion, steady = session.view.camera_motion, steady_camera(session)
    if motion is None or steady is None or motion.kind != "turns":
        raise CameraError("The background is put together of a camera that turns: find it first.")
    camera = session.view.camera
    loader = ClipLoader(
        video,
        camera,
        WorkingSize.for_camera(camera, 1),
        steady=steady,
        turns=turns_of(steady, motion),
    )
    return loader.panorama_in_colour().picture


def known_poses(session: Session, fitting: Mapping[Span, SegmentResult]) -> dict[int, Pose]:
    """The poses of a session's body by frame: tracked, or as a person set or drafted them."""
    skeleton = Skeleton.of(session.subject.body)
    poses = {k.frame: k.pose(skeleton) for k in session.subject.posed}
    for segment in fitting.values():
        frames = np.arange(segment.first, segment.last + 1)[segment.tracked]
        poses |= {int(frame): segment.trajectory.pose(int(frame)) for frame in frames}
    return poses


def _greys(video: Video) -> Iterator[NDArray[np.uint8] | None]:
    for _, picture in video.frames(0, video.info.frame_count):
        grey = None if picture is None else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        yield None if grey is None else np.asarray(grey, dtype=np.uint8)
