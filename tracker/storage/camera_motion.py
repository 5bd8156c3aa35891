"""Find the motion of a session's camera from the background of its film."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.camera_motion import CameraKind, FollowedPoints, find_camera_motion
from keypose.tracker.camera_motion.background import BodyBackground
from keypose.tracker.errors import CameraError
from keypose.tracker.files import read_own
from keypose.tracker.keypoints.model_files import cache_folder
from keypose.tracker.session.camera_motion import CameraFinding, CameraMotion
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.archive import archive_arrays, archive_bytes
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video

MOST_KEPT: Final = 40
"""Films whose points are kept."""
LARGEST_BYTES: Final = 2**30


@dataclass(frozen=True, eq=False)
class FoundCamera:
    """What was found of a session's camera.

    motion: None where it stands still.  points: of the background, good and refused; None once they
        are kept.  findings: of all that is doubtful.  focal: the focal length that its turns tell,
        as a share of the camera's, and the standard deviation of that; None where they do not.
    """

    kind: CameraKind
    motion: CameraMotion | None
    points: FollowedPoints | None
    findings: tuple[CameraFinding, ...]
    focal: tuple[float, float] | None

    def applied(self, session: Session) -> Session:
        """The session with this motion of its camera; whether that stands still is as found."""
        video = session.view.video.model_copy(update={"stands_still": self.kind == "static"})
        settings = session.settings.model_copy(update={"static_camera": None})
        fields = {"camera_motion": self.motion, "video": video, "settings": settings}
        return session.changed(fields)


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
    camera = session.view.camera
    background = BodyBackground(
        Skeleton.of(session.subject.body), camera, poses, session.view.ignore_masks
    )
    found = find_camera_motion(
        _greys(video),
        camera,
        session.view.video.frame_count,
        background,
        fixed=kind,
        progress=lambda done, expected: report(done / expected),
    )
    findings = tuple(
        CameraFinding(
            kind=one.kind, first_frame=one.first_frame, last_frame=one.last_frame,
            amount=float(one.amount),
        )
        for one in found.findings
    )  # fmt: skip
    motion = None
    if found.path is not None and found.kind != "static":
        motion = CameraMotion.of(found.kind, found.path, found.error_px, findings)
    focal = None if found.focal is None else (found.focal.scale, found.focal.sigma)
    return FoundCamera(found.kind, motion, found.points, findings, focal)


def keep_points(found: FoundCamera, folder: Path | None = None) -> None:
    """Keep the points that a motion was found by in this user's cache folder, if that can be
    done: they are only looked at, and can be found again."""
    if found.motion is None or found.points is None:
        return
    place = _points_place(found.motion, folder)
    content = archive_bytes(
        {"uv": found.points.uv, "good": found.points.good, "starts": found.points.starts}
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


def known_poses(session: Session, fitting: Mapping[Span, SegmentResult]) -> dict[int, Pose]:
    """The poses of a session's body by frame: tracked, or as a person set or drafted them."""
    skeleton = Skeleton.of(session.subject.body)
    found = {k.frame: k.pose(skeleton) for k in session.subject.posed}
    for segment in fitting.values():
        frames = np.arange(segment.first, segment.last + 1)[segment.tracked]
        found |= {int(frame): segment.trajectory.pose(int(frame)) for frame in frames}
    return found


def _greys(video: Video) -> Iterator[NDArray[np.uint8] | None]:
    for _, picture in video.frames(0, video.info.frame_count):
        grey = None if picture is None else cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        yield None if grey is None else np.asarray(grey, dtype=np.uint8)
