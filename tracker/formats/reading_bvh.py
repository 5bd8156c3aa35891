"""BVH files in: the hierarchy, its channels, and where they put every joint.

Any order of rotation channels; position channels at any joint replace its offset, as in animation
programs. An End Site is the joint `<parent>_end`. BVH is y up and
names no unit; centimetres are the custom.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import MOST_JOINTS, JointMotion, require_size
from keypose.tracker.geometry.rotations import Array, exp_rotation

LONGEST_HIERARCHY = 4_000_000
LONGEST_NAME = 5_000
MOST_CHANNELS = 12
"""Of one joint: its place and its turns need six."""

_CHANNELS = {f"{axis}{kind}": ("xyz".index(axis), kind) for axis in "xyz" for kind in
             ("position", "rotation")}  # fmt: skip


@dataclass
class _Joint:
    """One joint of the hierarchy: its channels are (column, axis, "position" or "rotation")."""

    name: str
    parent: int
    offset: Array = field(default_factory=lambda: np.zeros(3))
    channels: list[tuple[int, int, str]] = field(default_factory=list)


def read_bvh(file: str, content: bytes) -> JointMotion:
    """The motion in a BVH file's content; FormatError in one sentence."""
    text = content.decode("utf-8-sig")
    head, mark, tail = text.partition("MOTION")
    if not mark:
        raise FormatError(f"{file} has no MOTION section, so it is no whole BVH file.")
    if len(head) > LONGEST_HIERARCHY:
        raise FormatError(f"{file} has a hierarchy of {len(head)} letters, which is too much.")
    joints, columns = _hierarchy(file, iter(head.split()))
    count, seconds, rows = _header(file, tail)
    require_size(file, count, len(joints))
    values = _values(file, rows, count, columns)
    names = [joint.name for joint in joints]
    times_s: Array = seconds * np.arange(count, dtype=np.float64)
    return JointMotion.of(file, names, _positions(joints, values), times_s, "y up", None, "cm")


def _hierarchy(file: str, words: Iterator[str]) -> tuple[list[_Joint], int]:
    """The joints, parents first, and how many channels they have together."""
    joints: list[_Joint] = []
    open_joints: list[int] = []
    columns, waiting, names = 0, False, _Names()
    try:
        if next(words) != "HIERARCHY":
            raise FormatError(f"{file} does not begin with HIERARCHY, so it is no BVH file.")
        for word in words:
            key = word.upper()
            if key in ("ROOT", "JOINT", "END"):
                parent = open_joints[-1] if open_joints else -1
                if waiting or (parent < 0) != (key == "ROOT"):
                    raise FormatError(f"{file}: {key} does not belong where it stands.")
                label = next(words)
                name = f"{joints[parent].name}_end" if key == "END" else label
                joints.append(_Joint(names.unused(name), parent))
                _require_few(file, joints)
                waiting = True
            elif key == "{" and waiting:
                open_joints.append(len(joints) - 1)
                waiting = False
            elif key == "}" and open_joints and not waiting:
                open_joints.pop()
            elif key == "OFFSET" and open_joints:
                joints[open_joints[-1]].offset = np.array([float(next(words)) for _ in range(3)])
            elif key == "CHANNELS" and open_joints:
                for _ in range(_channel_count(file, joints[open_joints[-1]], next(words))):
                    axis, kind = _CHANNELS[next(words).lower()]
                    joints[open_joints[-1]].channels.append((columns, axis, kind))
                    columns += 1
            else:
                raise FormatError(f"{file}: {word[:40]!r} does not belong in its hierarchy.")
    except (StopIteration, ValueError, KeyError):
        raise FormatError(f"{file}: its hierarchy is damaged or not of the usual kind.") from None
    if open_joints or waiting:
        raise FormatError(f"{file}: its hierarchy does not end.")
    if not np.isfinite([joint.offset for joint in joints]).all():
        raise FormatError(f"{file} has an offset that is no number.")
    return joints, columns


class _Names:
    """The names given so far. A name that is taken gets underscores, one more each time."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._tried: dict[str, int] = {}

    def unused(self, name: str) -> str:
        tried = self._tried.get(name, 0)
        while (found := name + tried * "_") in self._taken:
            tried += 1
        self._tried[name] = tried
        self._taken.add(found)
        return found


def _require_few(file: str, joints: list[_Joint]) -> None:
    """Checked as each joint is read: a file may hold more than could be read in minutes."""
    if len(joints) > MOST_JOINTS:
        raise FormatError(f"{file} has more than {MOST_JOINTS} joints, which is too much.")
    if len(joints[-1].name) > LONGEST_NAME:
        raise FormatError(f"{file} has a joint whose name is longer than {LONGEST_NAME} letters.")


def _channel_count(file: str, joint: _Joint, word: str) -> int:
    count = int(word)
    if len(joint.channels) + count > MOST_CHANNELS:
        raise FormatError(f"{file} has a joint of more than {MOST_CHANNELS} channels.")
    return count


def _header(file: str, tail: str) -> tuple[int, float, str]:
    """How many frames, the seconds between them, and the text of their rows."""
    try:
        frames, time, rows = tail.lstrip().split("\n", 2)
        count, seconds = int(_after(frames, "Frames:")), float(_after(time, "Frame Time:"))
    except ValueError:
        raise FormatError(f"{file}: after MOTION come Frames: and Frame Time:.") from None
    if count < 1 or not 1e-6 < seconds < 1e4:
        raise FormatError(f"{file} says {count} frames, {seconds:g} s apart; both must be more.")
    return count, seconds, rows


def _after(line: str, label: str) -> str:
    if not line.strip().lower().startswith(label.lower()):
        raise ValueError
    return line.strip()[len(label) :]


def _values(file: str, rows: str, count: int, columns: int) -> Array:
    """(N, C) values of the channels."""
    values, found = np.empty(count * columns), 0
    try:
        for line in io.StringIO(rows):
            words = line.split(maxsplit=len(values) - found)  # no more of them than are wanted
            if found + len(words) > len(values):
                found = -1
                break
            values[found : found + len(words)] = [float(word) for word in words]
            found += len(words)
    except ValueError:
        raise FormatError(f"{file} has something else than numbers in its rows.") from None
    if found != len(values):
        holds = "more" if found < 0 else f"{found} numbers"
        raise FormatError(
            f"{file} should hold {count} rows of {columns} numbers and holds {holds}."
        )
    if not np.isfinite(values).all():
        raise FormatError(f"{file} has a channel that is not a finite number.")
    return values.reshape(count, columns)


def _positions(joints: list[_Joint], values: Array) -> Array:
    """(N, J, 3) in the file's world and unit: forward kinematics of the hierarchy."""
    N = len(values)
    Rs, ps = np.empty((len(joints), N, 3, 3)), np.empty((N, len(joints), 3))
    for i, joint in enumerate(joints):
        local, R = np.tile(joint.offset, (N, 1)), np.tile(np.eye(3), (N, 1, 1))
        for column, axis, kind in joint.channels:
            if kind == "position":
                local[:, axis] = values[:, column]
            else:
                turn = np.zeros((N, 3))
                turn[:, axis] = np.radians(values[:, column])
                R = R @ exp_rotation(turn)
        if joint.parent < 0:
            Rs[i], ps[:, i] = R, local
            continue
        above = Rs[joint.parent]
        Rs[i] = above @ R
        ps[:, i] = ps[:, joint.parent] + (above @ local[..., None])[..., 0]
    return ps
