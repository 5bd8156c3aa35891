"""The motion as three tables of comma-separated values, one row per frame.

joints: `frame`, `time_s`, then `<joint>_x_m`, `<joint>_y_m`, `<joint>_z_m` for every joint and
landmark: metres in the camera frame, x right, y down, z away from the camera; of one that moves, as
it was at that frame. Then the same as `<joint>_world_x_m` in the world of all files, y up, the
floor at zero.

angles: `frame`, `time_s`, then `<part>_rz_deg`, `<part>_ry_deg`, `<part>_rx_deg` for every part:
degrees of its rotation in its parent's frame (the root's: the camera frame), R = Rz·Ry·Rx. Then
`<root>_heading_deg`, `<root>_roll_deg` and `<root>_pitch_deg` against what is up, as in
`keypose.tracker.body.heading`. For a person then `<joint>_<angle>_deg` by the clinical names and
signs of `keypose.tracker.body.joint_angles`, such as `left_knee_flexion_deg`. Angles run on from
frame to frame, past half a turn where the motion does: of all triples that are one rotation, the
one nearest to the frame before is given. Whole turns of rz and rx that a part gains beside the
pole, where ry is a quarter turn and both turn about nearly one axis, are taken back there. Where
depth was lifted, each of these angles is followed by `<joint>_<angle>_expected_error_deg`: half of
all angles are off by less than that.

frames: what is known of every frame, and how far to trust it.

    frame, time_s
    pose                    keyframe, part_keyframe (of limbs alone), tracked, or missing
    verdict, words          good, check or lost, and why, of the segment that the frame is in; a
                            keyframe between two is in the one that begins there
    first_frame, last_frame the keyframes of that segment
    rank                    of the step to the next frame: how many motions the picture decided
    degrees_of_freedom      of how many
    film_frame              which frame of the video a row is: where the motion was given a rate of
                            its own, `frame` counts by that rate, and this has fractions
    timecode                of the nearest frame of the video; empty where the file has none
    filter_hz               cut-off of the low-pass filter (Butterworth, fourth order, without
                            delay); empty where the motion is as tracked
    note                    what a person wrote at this frame, on one line; "flag" where nothing was
                            written. Where it begins as a formula does, an apostrophe stands before
                            it, so that no spreadsheet computes it
    <part>_observability    of that step: 0, all guessed, to 1, all seen
    <part>_residual         of that step: difference of brightness, of 0 to 255
    film_1_error_px, …      where several films show the motion: how far joints lie from where each
                            film shows them, in its picture, the median of those that it sees
    <joint>_films           by how many films each joint is seen

What is not known is left empty: poses of frames that are not tracked, evidence where none was taken
(such as in a preview, or of a part that is not tracked), the step after the last frame.

Of several bodies in one table the columns but the first two are `NAME:column`.

The first line holds the names of the columns; there are no comments. Rows end in CR LF, as
RFC 4180 says.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.body.ground import Ground
from keypose.tracker.body.heading import CAMERA_UP, heading_first
from keypose.tracker.body.joint_angles import JointAngles
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import column_names, fixed_decimals
from keypose.tracker.formats.recording import Recording, named_apart
from keypose.tracker.formats.rotation_curves import known_smooth_euler
from keypose.tracker.formats.verdict_words import verdict_words
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS

IN_WORLD = "_world"
"""Follows a joint's name where its position is that in the world of all files."""

DECIMALS = 6
"""A micrometre, a microdegree, a microsecond."""


def joints_csv(
    skeleton: Skeleton,
    trajectory: Trajectory,
    times_s: Sequence[float] | Array,
    world: Ground | None = None,
    ps_seen: Array | None = None,
) -> str:
    """The table of joint positions; `times_s` (N,) are the times of the trajectory's frames.

    world: None where it is not known; its columns are left out then.
    ps_seen (N, J, 3): the positions before a camera that moves, in its own frame at every frame.
    """
    names, ps_camera = column_names(skeleton), trajectory.joints(skeleton)
    ps = ps_camera if ps_seen is None else ps_seen
    columns = [f"{name}_{axis}_m" for name in names for axis in "xyz"]
    if world is None:
        return _table(trajectory, times_s, columns, ps)
    columns += [f"{name}{IN_WORLD}_{axis}_m" for name in names for axis in "xyz"]
    both = np.concatenate([ps, world.points(ps_camera)], axis=1)
    return _table(trajectory, times_s, columns, both)


def angles_csv(
    skeleton: Skeleton,
    trajectory: Trajectory,
    times_s: Sequence[float] | Array,
    clinical: Sequence[JointAngles] = (),
    up_camera: ArrayLike = CAMERA_UP,
) -> str:
    """The table of joint angles; `times_s` (N,) are the times of the trajectory's frames."""
    columns = [f"{name}_r{axis}_deg" for name in skeleton.body.names for axis in "zyx"]
    columns += [f"{skeleton.body.names[0]}_{name}_deg" for name in ("heading", "roll", "pitch")]
    columns += [name for joint_angles in clinical for name in _clinical_columns(joint_angles)]
    Rs = trajectory.Rs_parent_part
    level = known_smooth_euler(heading_first(Rs[:, :1], up_camera))[:, 0] * [1.0, -1.0, 1.0]
    zyx = known_smooth_euler(Rs).reshape(len(Rs), -1)
    angles = np.rad2deg(np.hstack([zyx, level]))
    return _table(
        trajectory,
        times_s,
        columns,
        np.hstack([angles, *(_with_errors(joint) for joint in clinical)]),
    )


def _clinical_columns(angles: JointAngles) -> list[str]:
    """The names of a joint's columns, of each angle with its error where that is known."""
    kinds = ("deg",) if angles.errors_deg is None else ("deg", "expected_error_deg")
    joint = angles.joint
    return [f"{joint.name}_{angle.name}_{kind}" for angle in joint.angles for kind in kinds]


def _with_errors(angles: JointAngles) -> Array:
    """(N, columns) their values."""
    if angles.errors_deg is None:
        return angles.angles_deg
    both = np.stack([angles.angles_deg, angles.errors_deg], axis=-1)
    return np.asarray(both.reshape(len(both), -1))


def frames_csv(recording: Recording) -> str:
    """The table of frames."""
    parts, diagnostics = recording.skeleton.body.names, recording.tracks.diagnostics
    evidence = [f"{part}_{figure}" for figure in ("observability", "residual") for part in parts]
    steps = np.concatenate([diagnostics.observability, diagnostics.residual], axis=1)
    steps = np.concatenate([steps, np.full((1, 2 * len(parts)), np.nan)])
    of_films, film_columns = _of_films(recording)
    steps = np.concatenate([steps, of_films], axis=1)
    ranks = np.append(diagnostics.rank, -1)
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow([*_FRAME_COLUMNS, *evidence, *film_columns])
    for i, frame in enumerate(recording.frames):
        rank = [int(ranks[i]), recording.degrees_of_freedom] if ranks[i] >= 0 else ["", ""]
        time_s = fixed_decimals([recording.times_s[i]], DECIMALS)
        values = fixed_decimals(steps[i], DECIMALS)
        found_here = (
            *_finding(recording, i),
            *rank,
            *_sampling(recording, i),
            _noted(recording, i),
        )
        writer.writerow([frame, *time_s, *found_here, *values])
    return text.getvalue()


def tables_together(bodies: Sequence[Recording], tables: Sequence[str]) -> str:
    """The tables of several bodies, of the same frames, as one: columns are named apart."""
    each = [list(csv.reader(io.StringIO(table, newline=""))) for table in tables]
    heads = [named_apart(b, rows[0][2:]) for b, rows in zip(bodies, each, strict=True)]
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["frame", "time_s", *chain.from_iterable(heads)])
    for rows in zip(*(rows[1:] for rows in each), strict=True):
        writer.writerow([*rows[0][:2], *chain.from_iterable(row[2:] for row in rows)])
    return text.getvalue()


def _of_films(recording: Recording) -> tuple[Array, list[str]]:
    """(N, columns) what several films show, and the columns' names; none of one film."""
    films = recording.errors_by_film
    if not films:
        return np.zeros((len(recording), 0)), []
    px = np.stack([film.px for film in films])
    is_shown = np.isfinite(px)
    median = np.full(px.shape[:2], np.nan)
    anywhere = is_shown.any(axis=-1)
    median[anywhere] = np.nanmedian(px[anywhere], axis=-1)
    names = [f"film_{number}_error_px" for number in range(1, len(films) + 1)]
    names += [f"{joint}_films" for joint in JOINTS]
    return np.hstack([median.T, is_shown.sum(axis=0)]), names


_FRAME_COLUMNS = (
    *("frame", "time_s", "pose", "verdict", "words", "first_frame", "last_frame"),
    *("rank", "degrees_of_freedom", "film_frame", "timecode", "filter_hz", "note"),
)
_FORMULA = ("=", "+", "-", "@")


def _sampling(recording: Recording, i: int) -> tuple[str, str, str]:
    """film_frame, timecode and filter_hz of a row."""
    film = f"{recording.film_frames[i]:.4f}".rstrip("0").rstrip(".")
    hertz = "" if recording.filter_hz is None else f"{recording.filter_hz:g}"
    return film, recording.timecode_at(i) or "", hertz


def _noted(recording: Recording, i: int) -> str:
    """The note of a row."""
    texts = (" ".join(note.text.split()) or "flag" for note in recording.notes_at[i])
    words = " · ".join(texts)
    return f"'{words}" if words.startswith(_FORMULA) else words


def _finding(recording: Recording, i: int) -> tuple[str | int, ...]:
    """pose, verdict, words, first_frame, last_frame of a row."""
    if recording.segment_at[i] < 0:
        return ("tracked" if recording.tracks.tracked[i] else "missing", "", "", "", "")
    segment = recording.segments[recording.segment_at[i]]
    tracked = "part_keyframe" if recording.at_part_keyframe[i] else "tracked"
    pose = "keyframe" if recording.at_keyframe[i] else tracked
    kind, words = segment.verdict.kind, verdict_words(segment.verdict)
    return (pose, kind, words, segment.first_frame, segment.last_frame)


def _table(
    trajectory: Trajectory, times_s: Sequence[float] | Array, columns: list[str], values: Array
) -> str:
    if len(times_s) != len(trajectory):
        raise FormatError(
            f"{len(times_s)} times were given for a motion of {len(trajectory)} frames."
        )
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["frame", "time_s", *columns])
    rows = values.reshape(len(trajectory), -1)
    for i, (time_s, row) in enumerate(zip(times_s, rows, strict=True)):
        writer.writerow([trajectory.first_frame + i, *fixed_decimals([time_s, *row], DECIMALS)])
    return text.getvalue()
