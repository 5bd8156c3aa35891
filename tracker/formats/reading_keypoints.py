"""Read 2D keypoints: files of COCO, AlphaPose, MediaPipe, MMPose, SLEAP and DeepLabCut, or
OpenPose's folder.

What each kind of file looks like is in `keypoint_files`, the orders of keypoints in
`keypose.tracker.keypoints.layouts`. Names in the file count; without them, or where they are only
numbers, the number of keypoints says which layout it is; where several have that number, the limbs
do. Of several people in a frame the most confident counts. Pixels have their centres at integers;
shares of the picture's size, as MediaPipe writes them, become pixels by the size that the file
gives, or else the video's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from keypose.tracker.errors import ChoiceError, FormatError, listed
from keypose.tracker.formats.keypoint_files import read_people
from keypose.tracker.formats.people import People
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.layouts import LAYOUTS, keypoint_name, layouts_of
from keypose.tracker.keypoints.recognise_layout import recognised_layout

FARTHEST_PX: Final = 1e6
NORMALIZED: Final = 2.0
"""No person is so small in pixels: coordinates within this are shares of the picture's size."""
MOST_NUMBERS: Final = 10_000_000
"""Keypoints over all frames from the first to the last."""
BEYOND: Final = 0.02
"""Share of a file's frames, or two, that may lie beyond the video: detectors and labelled pictures
count one more or less at its ends."""
OTHER_RATE: Final = 0.01
"""Share by which frame rates differ of which one is not just the other one rounded."""


@dataclass(frozen=True)
class VideoFacts:
    """What the keypoints must fit: the video's frames, its size in pixels, its frames a second."""

    frame_count: int
    width: int
    height: int
    fps: float | None = None


def load_keypoints(
    path: Path,
    layout: str | None = None,
    video: VideoFacts | None = None,
    individual: str | None = None,
) -> Keypoints:
    """The keypoints in a file or a folder, of the first to the last frame that has any.

    layout: a name in `LAYOUTS`, for files that do not name their keypoints.
    video:  what they are of: keypoints of another size, rate or number of frames are refused.
    individual: which one, in files that tell individuals apart.
    FormatError in one sentence.
    """
    people = read_people(path, individual)
    if video is not None:
        people, _ = on_video(path.name, people, video)
    return keypoints_of(path.name, people, layout, video)


def on_video(
    file: str, people: People, video: VideoFacts, offset: int = 0
) -> tuple[People, tuple[Note, ...]]:
    """Number frames as the video does, `offset` frames later than the file; leave out what lies
    beyond its ends. FormatError where that is much."""
    frames = {frame + offset: persons for frame, persons in people.frames.items()}
    inside = {n: persons for n, persons in frames.items() if 0 <= n < video.frame_count}
    outside = sorted(n for n in frames.keys() - inside.keys() if any(frames[n]))
    if outside and (not inside or len(outside) > max(2, BEYOND * len(frames))):
        raise FormatError(
            f"{file} has keypoints at frames {min(frames)} to {max(frames)}, but the video's "
            f"frames are 0 to {video.frame_count - 1}: choose the frame at which it begins."
        )
    notes = (Note("frames beyond", (len(outside), video.frame_count - 1)),) if outside else ()
    return replace(people, frames=inside), notes


def keypoints_of(
    file: str, people: People, layout: str | None = None, video: VideoFacts | None = None
) -> Keypoints:
    """The keypoints of the people that a file lists, the surest of them in every frame; as
    `load_keypoints`."""
    people = _named(people)
    tables = _surest_person_by_frame(file, people)
    _require_rate(file, people.fps, video)
    size = _size(file, people, video)
    first, rows = _dense(file, tables)
    visibility = np.clip(rows[..., 2], 0.0, 1.0)
    uv = np.where(visibility[..., None] > 0, rows[..., :2], np.nan)
    names = _names(file, people, layout, uv)
    return Keypoints(first, names, _in_pixels(file, uv, size), visibility)


# --- tables


def _surest_person_by_frame(file: str, people: People) -> dict[int, Array]:
    """(L, 3) of u, v and confidence for every frame that shows anything.

    A person may have none at all, such as one that is only a box, and is passed over.
    """
    table_of_frame: dict[int, Array] = {}
    for frame, persons in people.frames.items():
        tables = [_table(file, numbers) for numbers in persons if numbers not in (None, [])]
        best = max(tables, key=lambda table: float(_confidence(table).sum()), default=None)
        for table in tables:
            _require_count(file, len(table), people)
        if best is not None and (best[:, 2] > 0).any():
            table_of_frame[frame] = best
    counts = sorted({len(table) for table in table_of_frame.values()})
    if not counts:
        raise FormatError(f"{file} holds no keypoint of anybody.")
    if len(counts) > 1:
        raise FormatError(f"{file} has people of {counts[0]} and of {counts[1]} keypoints.")
    return table_of_frame


def _table(file: str, numbers: Any) -> Array:
    """(L, 3) of u, v and confidence, from a flat list."""
    try:
        flat = np.array(numbers, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        flat = np.empty(1)
    if flat.ndim != 1 or not len(flat) or len(flat) % 3:
        raise FormatError(f"{file} has keypoints that are not u, v and confidence in turn.")
    if not np.isfinite(flat).all():
        raise FormatError(f"{file} has a keypoint that is not a finite number.")
    if np.abs(flat).max() > FARTHEST_PX:
        raise FormatError(f"{file} has a keypoint that is nowhere near a picture.")
    return flat.reshape(-1, 3)


def _confidence(table: Array) -> Array:
    """0 to 1; COCO's visibility 1 and 2 is sure."""
    return np.asarray(np.clip(table[:, 2], 0.0, 1.0))


def _dense(file: str, tables: Mapping[int, Array]) -> tuple[int, Array]:
    """The first frame, and (N, L, 3) from there to the last."""
    first, last = min(tables), max(tables)
    count = len(tables[first])
    if (last - first + 1) * count > MOST_NUMBERS:
        raise FormatError(
            f"{file} has keypoints from frame {first} to frame {last}, which is too many frames."
        )
    rows = np.zeros((last - first + 1, count, 3))
    for frame, table in tables.items():
        rows[frame - first] = table
    return first, rows


# --- what they are called


def _require_count(file: str, count: int, people: People) -> None:
    if people.names is not None:
        if count != len(people.names):
            raise FormatError(
                f"{file} has a person of {count} keypoints and names {len(people.names)}."
            )
        return
    layouts = LAYOUTS if people.layout is None else {people.layout: LAYOUTS[people.layout]}
    counts = sorted({len(names) for names in layouts.values()})
    if count not in counts:
        expected = listed([str(count) for count in counts])
        raise FormatError(f"{file} has a person of {count} keypoints; known are {expected}.")


def _names(file: str, people: People, layout: str | None, uv: Array) -> tuple[str, ...]:
    """The names of the keypoints (N, L, 2): the file's own, or those of its layout."""
    if people.names is not None:
        return _own_names(file, people.names, layout)
    count = uv.shape[1]
    layouts = layouts_of(count) if people.layout is None else (people.layout,)
    if layout is None:
        layout_name = recognised_layout(layouts, uv)
        if layout_name is None:
            may_be = " or ".join(layouts)
            words = f"{file} has {count} keypoints a person, which may be {may_be}."
            raise ChoiceError(words, "layout", layouts)
        return LAYOUTS[layout_name]
    if layout not in LAYOUTS:
        raise FormatError(f"There is no layout {layout!r}; there are {listed(list(LAYOUTS))}.")
    if layout not in layouts:
        raise FormatError(
            f"{file} has {count} keypoints a person and is {' or '.join(layouts)}, not {layout}."
        )
    return LAYOUTS[layout]


def _named(people: People) -> People:
    """Names that are only numbers, as annotation tools give them, say nothing but the order."""
    names = people.names
    return replace(people, names=None) if names and all(n.isdecimal() for n in names) else people


def _own_names(file: str, names_in_file: tuple[str, ...], layout: str | None) -> tuple[str, ...]:
    names = tuple(keypoint_name(name) for name in names_in_file)
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise FormatError(f"{file} names the keypoint {twice[0]} twice.")
    if layout is not None and names != LAYOUTS.get(layout):
        raise FormatError(f"{file} names its keypoints itself, and not as {layout} does.")
    return names


# --- the video they are of


def _require_rate(file: str, fps: float | None, video: VideoFacts | None) -> None:
    ours = None if video is None else video.fps
    if fps is not None and ours is not None and abs(fps / ours - 1) > OTHER_RATE:
        raise FormatError(
            f"{file} is of a video with {fps:.4g} frames a second; this one has {ours:.4g}."
        )


def _size(file: str, people: People, video: VideoFacts | None) -> tuple[float, float] | None:
    """Width and height of the pictures, by the file or else the video."""
    if len(people.sizes) > 1:
        raise FormatError(f"{file} is of pictures of different sizes.")
    size = next(iter(people.sizes), None)
    if size is not None and video is not None and size != (video.width, video.height):
        raise FormatError(
            f"{file} is of pictures of {size[0]:g} × {size[1]:g} pixels; "
            f"the video's are {video.width} × {video.height}."
        )
    return (video.width, video.height) if size is None and video is not None else size


def _in_pixels(file: str, uv: Array, size: tuple[float, float] | None) -> Array:
    """Shares of the picture's size are from edge to edge, and pixels from their centres."""
    if np.nanmax(np.abs(uv)) > NORMALIZED:
        return uv
    if size is None:
        raise FormatError(
            f"{file} has coordinates that are shares of a picture's size, which it does not give: "
            "add width and height to it."
        )
    return np.asarray(uv * np.array(size) - 0.5)
