"""Store what lies beside a session: an imported motion and keypoints, each written once.

Both are plain NumPy archives, as a tracks file is. An imported motion:

    first_frame     ()             index of the first pose's video frame
    part_names      (P,)           text
    Rs_parent_part  (N, P, 3, 3)   rotations in the parents' frames
    ps_camera_root  (N, 3)         metres

Of a session's own motion, reduced to keyframes, it holds the poses of the runs that the session
names; frames between these have none, NaN.

Keypoints, whose numbers have four bytes, a fraction of a thousandth of a pixel:

    first_frame  ()         index of the first row's video frame
    names        (L,)       text
    uv           (N, L, 2)  pixels, NaN where nothing was found
    visibility   (N, L)     from 0 to 1, 0 where uv is NaN
    p_hips       (N, L, 3)  metres, NaN where unknown; left out where no depth is known

and, of a draft of a film that shows no empty scene, where the person is (`mask_arrays.py`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import KeypointError, SessionError
from keypose.tracker.files import read_regular
from keypose.tracker.geometry.rotations import Array, transpose
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.session.references import KEYPOINT_RUN, FirstMotion, KeypointFile, OwnRun
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.archive import LARGEST_PACKED_BYTES, archive_arrays, archive_bytes
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.mask_arrays import MASK_ARRAYS, arrays_of_masks, masks_of_arrays


def carry_beside(session: Session, folder: Path, target: Path) -> None:
    """Copy the session's imported motion and the keypoints of its films to another folder;
    SessionError when one cannot be written there."""
    for body in session.bodies:
        about = session.about(body.id)
        of_films = (view.keypoints for view in about.views)
        for reference in (body.first_motion, *of_films):
            if reference is not None:
                _carry(folder / reference.file, target / reference.file)


def _carry(source: Path, place: Path) -> None:
    if place.exists():  # named by its content
        return
    try:
        content = read_regular(source, LARGEST_PACKED_BYTES)
    except OSError:  # tracking will report that it is missing
        return
    write_file(place, content, overwrite=True, error=SessionError)


MOST_MASK_BYTES = 64 * 2**20
"""Of masks beside keypoints, some 90,000 frames; with more the file could not be read again."""
REDUCED = "reduced motion"
"""What a session's own motion is said to be from."""


def save_first_motion(
    session: Session,
    session_path: Path,
    motion: Trajectory,
    source: str,
    matched: Mapping[str, str],
) -> Session:
    """Write the motion beside the session file; the session that refers to it, not yet saved."""
    name = _write(session.subject.body, session_path, motion)
    reference = FirstMotion(file=name, source=source, matched=dict(matched))
    return session.changed({"first_motion": reference})


def save_own_motion(session: Session, session_path: Path, motion: Trajectory) -> FirstMotion:
    """Write the motion that a session has, before it is reduced to keyframes; what refers to it.

    motion: every run of frames with poses is kept, in place of what was kept of these frames
        before; NaN frames are in no run. What was kept of other frames stays.
    """
    before = session.subject.first_motion
    if before is not None and before.own:
        trajectory = load_first_motion(session, session_path.parent)
        if trajectory is not None:
            motion = _overlaid(trajectory, motion)
    ends = np.flatnonzero(np.diff(np.r_[0, np.isfinite(motion.ps_camera_root[:, 0]), 0]))
    runs = [_own_run(motion, int(a), int(b)) for a, b in ends.reshape(-1, 2)]
    name = _write(session.subject.body, session_path, motion)
    return FirstMotion(file=name, source=REDUCED, own=tuple(runs))


def _overlaid(trajectory: Trajectory, motion: Trajectory) -> Trajectory:
    """A motion over another one: together as long as both need, NaN where neither has a pose."""
    first = min(trajectory.first_frame, motion.first_frame)
    frames = max(trajectory.last_frame, motion.last_frame) - first + 1
    Rs = np.full((frames, *motion.Rs_parent_part.shape[1:]), np.nan)
    ps = np.full((frames, 3), np.nan)
    for each in (trajectory, motion):
        there = np.isfinite(each.ps_camera_root).all(axis=1)
        rows = each.first_frame - first + np.flatnonzero(there)
        Rs[rows], ps[rows] = each.Rs_parent_part[there], each.ps_camera_root[there]
    return Trajectory(first, Rs, ps)


def _own_run(motion: Trajectory, start: int, stop: int) -> OwnRun:
    poses = motion.Rs_parent_part[start:stop], motion.ps_camera_root[start:stop]
    digest = hashlib.sha256(b"".join(array.tobytes() for array in poses)).hexdigest()[:12]
    first = motion.first_frame
    return OwnRun(first_frame=first + start, last_frame=first + stop - 1, digest=digest)


def _write(body: Body, session_path: Path, motion: Trajectory) -> str:
    content = archive_bytes(
        {
            "first_frame": np.array(motion.first_frame, dtype="<i8"),
            "part_names": np.array(body.names, dtype=np.str_),
            "Rs_parent_part": motion.Rs_parent_part.astype("<f8"),
            "ps_camera_root": motion.ps_camera_root.astype("<f8"),
        }
    )
    name = _first_motion_name(content)
    write_file(session_path.parent / name, content, overwrite=True, error=SessionError)
    return name


@dataclass(frozen=True, eq=False)
class OwnMotion:
    """The motion that a session had before it was reduced to keyframes, as its file holds it.

    file: the file's name.  names: of the parts of the body as it was then.
    """

    file: str
    names: tuple[str, ...]
    motion: Trajectory

    @classmethod
    def of(cls, session: Session, folder: Path) -> OwnMotion | None:
        """The own motion of a session, None where it has none; SessionError where it cannot be
        read.  folder: of the session's file."""
        reference = session.subject.first_motion
        if reference is None or not reference.own:
            return None
        return cls(reference.file, *_read(folder / reference.file))

    def over(self, session: Session, first: int, last: int) -> Trajectory | None:
        """The motion between two frames, for the body that a session has by now; None where its
        own motion is another one, or has no poses there."""
        reference = session.subject.first_motion
        if reference is None or reference.file != self.file:
            return None
        if reference.own_run(first, last) is None or not _has_poses(self.motion, first, last):
            return None
        rows = slice(first - self.motion.first_frame, last - self.motion.first_frame + 1)
        Rs, ps = self.motion.Rs_parent_part[rows], self.motion.ps_camera_root[rows]
        return _followed(self.names, Trajectory(first, Rs, ps), session.subject.body)


def load_first_motion(session: Session, folder: Path) -> Trajectory | None:
    """The motion a session's segments may start from; None where it has none. Its own follows the
    body, as keyframes do: a part that was added has no turn.

    folder: of the session's file.
    SessionError in one sentence when its file is missing or damaged, or was imported for another
    body.
    """
    reference, body = session.subject.first_motion, session.subject.body
    if reference is None:
        return None
    names, motion = _read(folder / reference.file)
    if reference.own:
        if not all(_has_poses(motion, run.first_frame, run.last_frame) for run in reference.own):
            raise SessionError(f"{reference.file} lacks poses that the session says it has.")
        return _followed(names, motion, body)
    if names != body.names:
        raise SessionError(
            f"{reference.file} was imported for other parts than the session's body has: "
            "import it again."
        )
    return motion


def _has_poses(motion: Trajectory, first: int, last: int) -> bool:
    """Whether a motion has a pose at every frame from `first` to `last`."""
    if not motion.first_frame <= first <= last <= motion.last_frame:
        return False
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    return bool(np.isfinite(motion.ps_camera_root[rows]).all())


def _followed(names: tuple[str, ...], motion: Trajectory, body: Body) -> Trajectory:
    """A motion of parts of these names for another body: parts of the same name turn as they did,
    those that it did not have do not turn."""
    if names == body.names:
        return motion
    Rs = np.tile(np.eye(3), (len(motion), len(body.names), 1, 1))
    Rs[~np.isfinite(motion.ps_camera_root).all(axis=1)] = np.nan
    row_of = {name: row for row, name in enumerate(names)}
    for part, name in enumerate(body.names):
        if name in row_of:
            Rs[:, part] = motion.Rs_parent_part[:, row_of[name]]
    return Trajectory(motion.first_frame, Rs, motion.ps_camera_root)


def _read(path: Path) -> tuple[tuple[str, ...], Trajectory]:
    """The names of the parts, and their motion; SessionError where there is none."""
    try:
        content = read_regular(path, LARGEST_PACKED_BYTES)
    except OSError as error:
        raise SessionError(
            f"The imported motion {str(path)!r} cannot be read: {error.strerror or error}; import "
            "it again, or set settings.initial to linear."
        ) from None
    try:
        if path.name != _first_motion_name(content):
            raise ValueError("its content does not fit its name")
        return _motion(archive_arrays(content))
    except ValueError as error:
        raise SessionError(f"The imported motion {str(path)!r} is damaged: {error}.") from None


def _motion(arrays: dict[str, NDArray[Any]]) -> tuple[tuple[str, ...], Trajectory]:
    try:
        names = tuple(str(name) for name in arrays["part_names"])
        R, t = arrays["Rs_parent_part"], arrays["ps_camera_root"]
        first = int(arrays["first_frame"])
    except (KeyError, TypeError):
        raise ValueError("its entries are not those of a motion") from None
    frames = len(t)
    if t.shape != (frames, 3) or R.shape != (frames, len(names), 3, 3) or frames < 1 or first < 0:
        raise ValueError("its entries do not fit together")
    is_posed = ~np.isnan(t).any(axis=1)
    R_known, t_known = R[is_posed], t[is_posed]
    are_poses = np.isfinite(t_known).all() and is_posed[[0, -1]].all()
    if not (are_poses and np.allclose(R_known @ transpose(R_known), np.eye(3), atol=1e-6)):
        raise ValueError("it holds poses that are none")
    return names, Trajectory(first, R, t)


def _first_motion_name(content: bytes) -> str:
    return f"first-{hashlib.sha256(content).hexdigest()[:12]}.npz"


def save_keypoints(
    session: Session,
    session_path: Path,
    keypoints: Keypoints,
    source: str,
    *,
    network: str = "",
    seeds: Sequence[int] = (),
    together: bool = False,
) -> Session:
    """Write keypoints beside the session file; the session that refers to them, not yet saved.

    source:  what found them, for people: a network's name, or the file they were imported from.
    network: fingerprint of the network; empty for an imported file.
    seeds:   frames where somebody said where the body is.
    together: whether the people around were followed as well.
    KeypointError in one sentence when the file cannot be written.
    """
    if sum(len(mask.packed) for mask in keypoints.masks or () if mask) > MOST_MASK_BYTES:
        keypoints = replace(keypoints, masks=None)
    content = archive_bytes(_arrays(keypoints))
    name = _keypoints_name(content)
    write_file(session_path.parent / name, content, overwrite=True, error=KeypointError)
    model = _model_of(session, network)
    reference = KeypointFile(
        file=name,
        source=source,
        network=network,
        seeds=tuple(sorted(set(seeds))),
        model=model,
        runs=_runs(keypoints) if model else (),
        masks=_shows_outlines(keypoints),
        together=together,
    )
    return session.changed({"keypoints": reference})


def _shows_outlines(keypoints: Keypoints) -> bool:
    """Whether it is known where the person is wherever one was seen."""
    is_seen = np.isfinite(keypoints.uv).all(axis=(1, 2))
    masks = keypoints.masks
    return masks is not None and all(masks[n] is not None for n in np.flatnonzero(is_seen))


def _model_of(session: Session, network: str) -> str:
    """The SHA-256 of the network that a session has chosen; empty if another one found."""
    from keypose.tracker.keypoints.detectors import detector_fingerprint  # what runs networks

    with suppress(KeypointError):  # it is not here any more
        model = find_model(session.settings.network_used)
        if network == detector_fingerprint(model):
            return model.sha256
    return ""


def _runs(keypoints: Keypoints) -> tuple[str, ...]:
    """What `KeypointFile.runs` are of keypoints."""

    def digest(first: int) -> str:
        arrays = _arrays(keypoints.over(first, first + KEYPOINT_RUN - 1))
        content = b"\0".join(arrays[name].tobytes() for name in sorted(arrays))
        return hashlib.sha256(content).hexdigest()[:8]

    return tuple(digest(first) for first in range(0, keypoints.last_frame + 1, KEYPOINT_RUN))


def one_focal(session: Session) -> SteadyCamera | None:
    """A session's camera without its zoom; None where it has none."""
    path = session.camera_path
    if path is None or not path.zooms:
        return None
    return SteadyCamera.at_one_focal(session.view.camera, path)


def at_one_focal(session: Session, keypoints: Keypoints) -> Keypoints:
    """Keypoints of a session's film as its camera sees them without its zoom."""
    steady = one_focal(session)
    return keypoints if steady is None else keypoints.steadied(steady)


def keypoints_of_session(session: Session, folder: Path) -> Keypoints | None:
    """The keypoints a session's segments are tracked with; None where it has none.

    folder: of the session's file.
    KeypointError in one sentence when their file is missing, damaged, or of a longer film.
    """
    if session.view.keypoints is None:
        return None
    keypoints = load_keypoints(folder / session.view.keypoints.file)
    if keypoints.last_frame >= session.view.video.frame_count:
        raise KeypointError(
            f"{session.view.keypoints.file} holds keypoints up to frame {keypoints.last_frame}, "
            f"but the video ends at {session.view.video.frame_count - 1}: find them again."
        )
    return keypoints


def load_keypoints(path: Path) -> Keypoints:
    """The keypoints in a file; KeypointError in one sentence when there are none."""
    try:
        content = read_regular(path, LARGEST_PACKED_BYTES)
    except OSError as error:
        raise KeypointError(
            f"The keypoints {str(path)!r} cannot be read: {error.strerror or error}; find them "
            "again."
        ) from None
    try:
        if path.name != _keypoints_name(content):
            raise ValueError("its content does not fit its name")
        return _keypoints(archive_arrays(content))
    except ValueError as error:
        raise KeypointError(
            f"The keypoints {str(path)!r} are damaged: {error}; find them again."
        ) from None


def _arrays(keypoints: Keypoints) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        "first_frame": np.array(keypoints.first_frame, dtype="<i8"),
        "names": np.array(keypoints.names, dtype=np.str_),
        "uv": keypoints.uv.astype("<f4"),
        "visibility": keypoints.visibility.astype("<f4"),
    }
    if keypoints.p_hips is not None:
        arrays["p_hips"] = keypoints.p_hips.astype("<f4")
    if keypoints.masks is not None:
        arrays |= arrays_of_masks(keypoints.masks)
    return arrays


def _keypoints(arrays: dict[str, NDArray[Any]]) -> Keypoints:
    try:
        names = tuple(str(name) for name in arrays["names"])
        first = int(arrays["first_frame"])
        uv, visibility = _numbers(arrays["uv"]), _numbers(arrays["visibility"])
        p_hips = _numbers(arrays["p_hips"]) if "p_hips" in arrays else None
        mask_arrays = [arrays[name] for name in MASK_ARRAYS] if "packed" in arrays else None
    except (KeyError, TypeError):
        raise ValueError("its entries are not those of keypoints") from None
    shape = (len(uv), len(names))
    fits = uv.shape == (*shape, 2) and visibility.shape == shape
    if not fits or (p_hips is not None and p_hips.shape != (*shape, 3)) or first < 0:
        raise ValueError("its entries do not fit together")
    if 0 in shape or len(set(names)) < len(names):
        raise ValueError("it holds no keypoints, or two of one name")
    is_known = np.isfinite(uv).all(axis=-1)
    if not ((visibility >= 0) & (visibility <= 1)).all() or visibility[~is_known].any():
        raise ValueError("it holds visibilities that are none")
    masks = None if mask_arrays is None else masks_of_arrays(*mask_arrays)
    if masks is not None and len(masks) != len(uv):
        raise ValueError("its masks are of other frames")
    return Keypoints(first, names, uv, visibility, p_hips, masks=masks)


def _numbers(array: NDArray[Any]) -> Array:
    if array.dtype.kind != "f":
        raise ValueError("its entries are not those of keypoints")
    return array.astype(np.float64)


def _keypoints_name(content: bytes) -> str:
    return f"keypoints-{hashlib.sha256(content).hexdigest()[:12]}.npz"
