"""Draw keyframe sheets and many frames as pictures, for command line and page alike."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from keypose.app.editor.part_keyframes import keyed_words
from keypose.app.export.picture_names import picture_names
from keypose.app.export.report.subject import Subject, subject_of
from keypose.app.orders.drawing import PictureOrder, SheetOrder
from keypose.app.render.lettering import write, written_width
from keypose.app.render.palette import PAPER, TEXT, Colour, Picture
from keypose.app.render.poses import KnownPoses
from keypose.app.render.stills import still
from keypose.app.render.studio import ViewStyle, png, rectified, snapshot
from keypose.tracker.errors import SessionError
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video

STATE_COLOURS: Mapping[str, Colour] = {
    "good": (8, 106, 84),
    "check": (190, 126, 10),
    "lost": (171, 44, 18),
    "outdated": (112, 121, 133),
    "none": (178, 185, 194),
}
"""As on the page in daylight."""
FAINT: Colour = (203, 208, 216)
CELL_WIDTHS = (96, 420)
WIDEST = 2000
ASPECT = 1.5
"""A sheet is about so many times as wide as high."""


@dataclass(frozen=True)
class Cell:
    """One keyframe. picture: None where there is none to show. state, interval: of the stretch to
    the next keyframe, None for the last. limbs: what alone is keyed, where not the whole body."""

    picture: Picture | None
    frame: int
    time_s: float
    interval: int | None
    state: str | None
    limbs: str = ""


def sheet_layout(count: int, aspect: float) -> tuple[int, tuple[int, int]]:
    """Columns, and the size (width, height) of the pictures, for `count` pictures of that shape
    (width over height)."""
    columns = min(range(1, count + 1), key=lambda columns: _oddness(columns, count, aspect))
    least, most = CELL_WIDTHS
    width = int(np.clip(WIDEST // columns, least, most))
    height = max(1, round(width / aspect))
    if height > 1.4 * most:
        width, height = max(1, round(1.4 * most * aspect)), round(1.4 * most)
    return columns, (width, height)


def _oddness(columns: int, count: int, aspect: float) -> float:
    """How far the sheet is from the wished-for shape, and how much of it stays empty."""
    rows = -(-count // columns)
    shape = abs(math.log(columns * aspect / rows / ASPECT))
    return shape + 1.5 * (rows * columns - count) / count


def sheet(cells: Iterator[Cell] | Sequence[Cell], columns: int, size: tuple[int, int]) -> Picture:
    """The sheet; pictures are brought to `size` one after the other."""
    width, height = size
    letter_px = float(np.clip(width / 19, 7, 15))
    foot, gap = round(3.9 * letter_px), max(8, width // 24)
    drawn = [_cell(cell, size, foot, letter_px) for cell in cells]
    rows = -(-len(drawn) // columns)
    shape = (gap + rows * (height + foot + gap), gap + columns * (width + gap), 3)
    whole = np.full(shape, PAPER, dtype=np.uint8)
    for i, picture in enumerate(drawn):
        row, column = divmod(i, columns)
        top, left = gap + row * (height + foot + gap), gap + column * (width + gap)
        whole[top : top + height + foot, left : left + width] = picture
    return whole


def _cell(cell: Cell, size: tuple[int, int], foot: int, letter_px: float) -> Picture:
    width, height = size
    drawn = np.full((height + foot, width, 3), PAPER, dtype=np.uint8)
    if cell.picture is None:
        drawn[:height] = 128
        _centred(drawn[:height], "missing", letter_px)
    else:
        drawn[:height] = cv2.resize(cell.picture, size, interpolation=cv2.INTER_AREA)
    top = height + max(2, round(0.35 * letter_px))
    bar = max(3, round(0.36 * letter_px))
    drawn[top : top + bar] = FAINT if cell.state is None else STATE_COLOURS[cell.state]
    baseline = top + bar + round(1.9 * letter_px)
    name = str(cell.frame)
    write(drawn, name, 0, baseline, letter_px, (24, 27, 33))
    left = written_width(name, letter_px) + round(0.9 * letter_px)
    if math.isfinite(cell.time_s):
        time = f"{cell.time_s:.2f} s"
        write(drawn, time, left, baseline, 0.85 * letter_px, TEXT)
        left += written_width(time, 0.85 * letter_px) + round(letter_px)
    if cell.limbs and left + written_width(cell.limbs, 0.85 * letter_px) <= width:
        write(drawn, cell.limbs, left, baseline, 0.85 * letter_px, TEXT)
    if cell.interval is not None:
        words = f"+{cell.interval}"
        at = width - written_width(words, letter_px) - 1
        if at > left and cell.state is not None:
            write(drawn, words, at, baseline, letter_px, STATE_COLOURS[cell.state])
    return drawn


def _centred(picture: Picture, words: str, letter_px: float) -> None:
    height, width = picture.shape[:2]
    left = (width - written_width(words, letter_px)) // 2
    if left > 0:
        write(picture, words, left, round((height + letter_px) / 2), letter_px, (238, 240, 243))


MOST_KEYFRAMES = 2000


def sheet_png(
    session: Session,
    session_path: Path,
    video: Video,
    order: SheetOrder,
    drawn: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[bytes, str | None]:
    """The PNG file's bytes, and what a person should know of it, a sentence.

    drawn: receives how many of how many keyframes are drawn.
    """
    keyed, count = (
        len(session.subject.keyframes),
        len(session.subject.keyframes) + len(session.subject.part_keyframes),
    )
    if not keyed or count > MOST_KEYFRAMES:
        words = f"more than {MOST_KEYFRAMES}" if keyed else "no"
        lacking = session.subject_in(session_path.name)
        raise SessionError(f"{lacking} has {words} keyframes to draw.")
    fitting, size = sheet_layout(count, session.view.video.width / session.view.video.height)
    subject = subject_of(session, session_path, video.info)
    look = ViewStyle("main", order.style, order.opacity, order.tint)
    cells = _cells(subject, video, size, look, lambda done: drawn(done, count))
    return png(sheet(cells, order.columns or fitting, size)), subject.problem


def _cells(
    subject: Subject,
    video: Video,
    size: tuple[int, int],
    look: ViewStyle,
    drawn: Callable[[int], None],
) -> Iterator[Cell]:
    session = subject.session
    limbs = {
        k.frame: keyed_words(session.subject.body, k.parts) for k in session.subject.part_keyframes
    }
    for done, frame in enumerate(sorted({*subject.keys, *limbs}), start=1):
        after = None if frame in limbs else subject.after(frame)
        small: Picture | None = None
        pose = subject.poses.pose(frame)
        if pose is not None and rectified(session, video, frame) is not None:
            beside = subject.poses.figures_beside(frame)
            picture = snapshot(session, video, frame, pose, look, beside)
            small = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
        interval, state = None, None
        if after is not None:
            interval, state = after[1] - after[0], subject.states[after]
        if frame in limbs:
            around = [span for span in subject.spans if span[0] < frame < span[1]]
            state = subject.states[around[0]] if around else None
        note = f"{limbs[frame]} only" if frame in limbs else ""
        yield Cell(small, frame, subject.time_s(frame), interval, state, note)
        drawn(done)


def write_pictures(
    out: Path,
    session: Session,
    video: Video,
    poses: KnownPoses,
    frames: Sequence[int],
    wanted: PictureOrder,
    drawn: Callable[[int, int], None] = lambda done, of: None,
) -> None:
    """A zip with frame0001.png and so on; `drawn` receives how many of how many are done."""
    names = picture_names(video.info, frames)
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as archive:  # PNG is packed already
        for done, (frame, name) in enumerate(zip(frames, names, strict=True), start=1):
            content = png(still(session, video, frame, poses, wanted))
            archive.writestr(zipfile.ZipInfo(name), content)
            drawn(done, len(frames))
