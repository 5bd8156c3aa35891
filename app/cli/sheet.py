"""`keypose sheet`: all keyframes on one picture."""

from __future__ import annotations

import argparse

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_output,
    add_session,
    note,
    whole_number,
)
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import add_look, session_to_draw
from keypose.app.export.drawable import require_tint

_EXAMPLES = """\
  keypose sheet session.json --out keyframes.png
  keypose sheet session.json --columns 4 --style wire --out keyframes.png --overwrite
"""


def add(commands: Subcommands) -> None:
    summary = "Draw all keyframes on one sheet, a PNG file"
    details = (
        "Each picture is labelled with its frame, its time and the number of frames to the "
        "next keyframe. The bar below has the colour of that segment's verdict: green good, "
        "yellow check, red lost, grey not tracked or outdated."
    )
    command = add_command(commands, "sheet", run, summary, details, _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--columns",
        metavar="N",
        type=whole_number(1, 100),
        help="pictures per row; default: automatic",
    )
    add_look(command)
    add_output(command, "FILE.png")


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.export.pictures import sheet_png
    from keypose.app.render.studio import ViewStyle
    from keypose.tracker.storage.atomic import write_file
    from keypose.tracker.storage.files import open_video_of

    session, out = session_to_draw(arguments, "picture", ".png"), arguments.out
    require_tint(session, arguments.tint)
    look = ViewStyle("main", arguments.style, arguments.opacity / 100, arguments.tint)
    with open_video_of(session, arguments.session) as video:
        content, problem = sheet_png(session, arguments.session, video, look, arguments.columns)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    note(problem)
    return 0
