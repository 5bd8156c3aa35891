"""Read BVH files: the hierarchy, its channels, and where they put every joint.

Any order of rotation channels; position channels at any joint replace its offset, as in animation
programs. A name is the rest of its line. An End Site is the joint `<parent>_end`; one without a
length says nothing and is left out. As many rows are read as there are, whatever `Frames:` says.
BVH names neither its unit nor which way is up: centimetres and y up are the custom, and the rest
pose shows where that is not so.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import (
    METRES,
    MOST_JOINTS,
    MOST_NUMBERS,
    JointMotion,
    require_size,
)
from keypose.tracker.formats.text import Note, decoded, with_decimal_points
from keypose.tracker.geometry.rotations import Array, exp_rotation

LONGEST_HIERARCHY = 4_000_000
LONGEST_NAME = 5_000
MOST_CHANNELS = 12
"""Of one joint: its place and its turns need six."""
SHORTEST = 1e-6
"""Length of an End Site, in the file's unit, that says where it is."""

_CHANNELS = {
    f"{axis}{kind}": ("xyz".index(axis), kind)
    for axis in "xyz"
    for kind in ("position", "rotation")
}
_TOKEN = re.compile(r"(?i)(?<!\S)(ROOT|JOINT|END)\s+([^\n{]*)|[{}]|[^\s{}]+")
_MOTION = re.compile(r"(?i)(?<![^\s}])MOTION\s+FRAMES\s*:\s*(\S+)\s+FRAME\s+TIME\s*:\s*(\S+)[^\n]*")


@dataclass
class _Joint:
    """One joint of the hierarchy: its channels are (column, axis, "position" or "rotation")."""

    name: str
    parent: int
    is_end: bool
    offset: Array = field(default_factory=lambda: np.zeros(3))
    channels: list[tuple[int, int, str]] = field(default_factory=list)


def read_bvh(file: str, content: bytes) -> JointMotion:
    """Read the motion in a BVH file's content; FormatError in one sentence."""
    text = with_decimal_points(decoded(content))
    if not text.lstrip()[:9].upper() == "HIERARCHY":
        raise FormatError(f"{file} does not begin with HIERARCHY, so it is no BVH file.")
    mark = _MOTION.search(text)
    if mark is None:
        raise FormatError(f"{file} has no MOTION with Frames: and Frame Time:, so it is not whole.")
    if mark.start() > LONGEST_HIERARCHY:
        raise FormatError(f"{file} has a hierarchy of {mark.start()} letters, which is too much.")
    joints, columns = _hierarchy(file, _TOKEN.finditer(text, 0, mark.start()))
    seconds = _seconds(file, mark[2])
    values = _values(file, text[mark.end() :], columns, mark[1])
    notes = () if mark[1] == str(len(values)) else (Note("row count", (mark[1][:20], len(values))),)
    require_size(file, len(values), len(joints))
    kept = [i for i, joint in enumerate(joints) if not joint.is_end or _length(joint) > SHORTEST]
    names = [joints[i].name for i in kept]
    times_s: Array = seconds * np.arange(len(values), dtype=np.float64)
    rest = _rest(joints)[kept] * METRES["cm"]
    ps = _positions(joints, values)[:, kept]
    return JointMotion.of(file, names, ps, times_s, "y up", None, "cm", rest_m=rest, notes=notes)


def _length(joint: _Joint) -> float:
    return float(np.linalg.norm(joint.offset))


def _hierarchy(file: str, tokens: Iterator[re.Match[str]]) -> tuple[list[_Joint], int]:
    """The joints, parents first, and how many channels they have together."""
    joints: list[_Joint] = []
    open_joints: list[int] = []
    columns, waiting, names = 0, False, _Names()
    try:
        next(tokens)  # HIERARCHY
        for token in tokens:
            key = (token[1] or token[0]).upper()
            if token[1] is not None:
                parent = open_joints[-1] if open_joints else -1
                if waiting or (parent < 0) != (key == "ROOT"):
                    raise FormatError(f"{file}: {key} does not belong where it stands.")
                label = f"{joints[parent].name}_end" if key == "END" else token[2].strip()
                joints.append(_Joint(names.unused(label), parent, key == "END"))
                _require_few(file, joints)
                waiting = True
            elif key == "{" and waiting:
                open_joints.append(len(joints) - 1)
                waiting = False
            elif key == "}" and open_joints and not waiting:
                open_joints.pop()
            elif key == "OFFSET" and open_joints:
                offset = np.array([float(next(tokens)[0]) for _ in range(3)])
                joints[open_joints[-1]].offset = offset
            elif key == "CHANNELS" and open_joints:
                for _ in range(_channel_count(file, joints[open_joints[-1]], next(tokens)[0])):
                    axis, kind = _CHANNELS[next(tokens)[0].lower()]
                    joints[open_joints[-1]].channels.append((columns, axis, kind))
                    columns += 1
            else:
                raise FormatError(f"{file}: {token[0][:40]!r} does not belong in its hierarchy.")
    except (StopIteration, ValueError, KeyError):
        raise FormatError(f"{file}: its hierarchy is damaged or not of the usual kind.") from None
    if open_joints or waiting or not joints:
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
        while (candidate := name + tried * "_") in self._taken:
            tried += 1
        self._tried[name] = tried
        self._taken.add(candidate)
        return candidate


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


def _seconds(file: str, word: str) -> float:
    try:
        seconds = float(word)
    except ValueError:
        raise FormatError(f"{file} has {word[:20]!r} as Frame Time:, which is no number.") from None
    if not 1e-6 < seconds < 1e4:
        raise FormatError(f"{file} says that its frames are {seconds:g} s apart.")
    return seconds


def _values(file: str, rows: str, columns: int, said: str) -> Array:
    """(N, C) values of the channels.

    Rows may be broken over lines where there are as many as the file says; otherwise each line is
    one, and the last may be cut short.
    """
    if not columns:
        return np.empty((1, 0))
    values, count_read, row_lengths = np.empty(min(len(rows) // 2 + 1, MOST_NUMBERS)), 0, [0]
    try:
        for line in io.StringIO(rows):
            # no more of them than there is room
            words = line.split(maxsplit=len(values) - count_read)
            if count_read + len(words) > len(values):
                raise FormatError(f"{file} holds more than {MOST_NUMBERS} numbers, too many.")
            values[count_read : count_read + len(words)] = [float(word) for word in words]
            count_read += len(words)
            if len(words) not in (0, columns):
                row_lengths.append(len(words))
    except ValueError:
        raise FormatError(f"{file} has something else than numbers in its rows.") from None
    count, cut = divmod(count_read, columns)
    is_as_said = not cut and said == str(count)
    if not count or not (is_as_said or sum(row_lengths) == cut):
        raise FormatError(
            f"{file} should hold rows of {columns} numbers and holds one of {row_lengths[-1]}."
        )
    values = values[: count * columns]
    if not np.isfinite(values).all():
        raise FormatError(f"{file} has a channel that is not a finite number.")
    return values.reshape(count, columns)


def _rest(joints: list[_Joint]) -> Array:
    """(J, 3) where no joint is turned and each lies at its offset."""
    ps = np.empty((len(joints), 3))
    for i, joint in enumerate(joints):
        ps[i] = joint.offset + (ps[joint.parent] if joint.parent >= 0 else 0.0)
    return ps


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
