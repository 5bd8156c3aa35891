"""The motion as two tables of comma-separated values, one row per frame.

joints: `frame`, `time_s`, then `<joint>_x_m`, `<joint>_y_m`, `<joint>_z_m` for every joint and
landmark: metres in the camera frame, x right, y down, z away from the camera.

angles: `frame`, `time_s`, then `<part>_rz_deg`, `<part>_ry_deg`, `<part>_rx_deg` for every part:
degrees of its rotation in its parent's frame (the root's: the camera frame), R = Rz·Ry·Rx. Angles
lie within ±180, that of y within ±90.

The first line holds the names of the columns; there are no comments. Rows end in CR LF, as
RFC 4180 says.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from tracker.errors import FormatError
from tracker.geometry import Array, euler_from_rotation
from tracker.pose import joint_names
from tracker.skeleton import Skeleton
from tracker.trajectory import Trajectory

DECIMALS = 6
"""A micrometre, a microdegree, a microsecond."""


def joints_csv(skeleton: Skeleton, trajectory: Trajectory, times_s: Sequence[float] | Array) -> str:
    """The table of joint positions; `times_s` (N,) are the times of the trajectory's frames."""
    columns = [f"{name}_{axis}_m" for name in column_names(skeleton) for axis in "xyz"]
    return _table(trajectory, times_s, columns, trajectory.joints(skeleton))


def angles_csv(skeleton: Skeleton, trajectory: Trajectory, times_s: Sequence[float] | Array) -> str:
    """The table of joint angles; `times_s` (N,) are the times of the trajectory's frames."""
    columns = [f"{name}_r{axis}_deg" for name in skeleton.body.names for axis in "zyx"]
    angles = np.rad2deg(euler_from_rotation(trajectory.Rs_parent_part))
    return _table(trajectory, times_s, columns, angles)


def column_names(skeleton: Skeleton) -> tuple[str, ...]:
    """Names as of `joint_names`; a landmark whose name is not the only one carries its part's."""
    names = joint_names(skeleton)
    owners = [part.name for part in skeleton.body.parts for _ in part.landmarks]
    landmarks = names[skeleton.part_count :]
    pairs = zip(owners, landmarks, strict=True)
    marks = (f"{owner}.{name}" if names.count(name) > 1 else name for owner, name in pairs)
    return (*skeleton.body.names, *marks)


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
        writer.writerow([trajectory.first_frame + i, *_written([time_s, *row])])
    return text.getvalue()


def _written(numbers: Iterable[float]) -> list[str]:
    """Fixed decimals, and no minus before a zero."""
    return [f"{round(float(number), DECIMALS) + 0.0:.{DECIMALS}f}" for number in numbers]
