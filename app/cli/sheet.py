"""`keypose sheet`: all keyframes on one picture."""

from __future__ import annotations

import argparse

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_order,
    add_output,
    add_session,
    note,
    order_of,
)
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import session_to_draw
from keypose.app.export.drawable import require_tint
from keypose.app.orders.drawing import SheetOrder

_EXAMPLES = """\
  keypose sheet session.json --out keyframes.png
  keypose sheet session.json --columns 4 --style wire --out keyframes.png --overwrite
"""


def add(commands: Subcommands) -> None:
    details = (
        "Each picture is labelled with its frame, its time and the number of frames to the "
        "next keyframe. The bar below has the colour of that segment's verdict: green good, "
        "yellow check, red lost, grey not tracked or outdated."
    )
    command = add_command(commands, "sheet", run, details, _EXAMPLES)
    add_session(command)
    add_order(command, SheetOrder)
    add_output(command, "FILE.png")


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.export.pictures import sheet_png
    from keypose.tracker.storage.atomic import write_file
    from keypose.tracker.storage.files import open_video_of

    session, out = session_to_draw(arguments, "picture", ".png"), arguments.out
    order = order_of(SheetOrder, arguments)
    require_tint(session, order.tint)
    with open_video_of(session, arguments.session) as video:
        content, problem = sheet_png(session, arguments.session, video, order)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    note(problem)
    return 0
