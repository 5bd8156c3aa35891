"""`keypose sheet`: all keyframes on one picture."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

from app.cli.arguments import (
    Subcommands,
    add_command,
    add_output,
    add_session,
    note,
    whole_number,
)
from app.cli.json_output import print_written
from app.cli.views import add_look, require_tint, session_to_draw
from tracker.errors import SessionError

if TYPE_CHECKING:
    from app.export.report.subject import Subject
    from app.render.palette import Picture
    from app.render.sheet import Cell
    from tracker.video import Video

MOST_KEYFRAMES = 2000
_EXAMPLES = """\
  keypose sheet session.json --out keyframes.png
  keypose sheet session.json --columns 4 --style wire --out keyframes.png --overwrite
"""


def add(commands: Subcommands) -> None:
    summary = "Draw all keyframes on one sheet, a PNG file"
    details = (
        "Under each picture stand its frame, its time and how many frames it is to the next "
        "keyframe; the bar has the colour of that stretch's verdict: green good, yellow check, red "
        "lost, grey not tracked as it is posed now."
    )
    command = add_command(commands, "sheet", run, summary, details, _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--columns", metavar="N", type=whole_number(1, 100), help="default: as it fits"
    )
    add_look(command)
    add_output(command, "FILE.png")


def run(arguments: argparse.Namespace) -> int:
    from app.export.report.subject import subject_of
    from app.render.sheet import sheet, sheet_layout
    from app.render.snapshots import png
    from tracker.storage.atomic import write_file
    from tracker.storage.files import open_video_of

    session, out = session_to_draw(arguments, "picture", ".png"), arguments.out
    require_tint(session, arguments.tint)
    keyed, parts = len(session.keyframes), len(session.part_keyframes)
    count = keyed + parts
    if not keyed or count > MOST_KEYFRAMES:
        words = f"more than {MOST_KEYFRAMES}" if keyed else "no"
        raise SessionError(f"{arguments.session.name} has {words} keyframes to draw.")
    columns, size = sheet_layout(count, session.video.width / session.video.height)
    with open_video_of(session, arguments.session) as video:
        subject = subject_of(session, arguments.session, video.info)
        cells = _cells(subject, video, size, arguments)
        content = png(sheet(cells, arguments.columns or columns, size))
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    note(subject.problem)
    return 0


def _cells(
    subject: Subject, video: Video, size: tuple[int, int], arguments: argparse.Namespace
) -> Iterator[Cell]:
    import cv2
    import numpy as np

    from app.editor.part_edits import keyed_words
    from app.render.sheet import Cell
    from app.render.snapshots import Look, rectified, snapshot

    look = Look("main", arguments.style, arguments.opacity / 100, arguments.tint)
    session = subject.session
    limbs = {k.frame: keyed_words(session.body, k.parts) for k in session.part_keyframes}
    for frame in sorted({*subject.keys, *limbs}):
        after = None if frame in limbs else subject.after(frame)
        small: Picture | None = None
        pose = subject.poses.pose(frame)
        if pose is not None and rectified(subject.session, video, frame) is not None:
            picture = snapshot(subject.session, video, frame, pose, look)
            small = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
        interval, state = None, None
        if after is not None:
            interval, state = after[1] - after[0], subject.states[after]
        if frame in limbs:
            around = [span for span in subject.spans if span[0] < frame < span[1]]
            state = subject.states[around[0]] if around else None
        said = f"{limbs[frame]} only" if frame in limbs else ""
        yield Cell(small, frame, subject.time_s(frame), interval, state, said)
