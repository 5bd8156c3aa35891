"""`keypose sheet`: all keyframes on one picture."""

from __future__ import annotations

import argparse

from keypose.app.cli.arguments import note, order_of
from keypose.app.cli.bodies import about_one
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import session_to_draw
from keypose.app.export.drawable import require_tint
from keypose.app.export.pictures import sheet_png
from keypose.app.orders.drawing import SheetOrder
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.files import open_video_of


def run(arguments: argparse.Namespace) -> int:
    whole, out = session_to_draw(arguments, "picture", ".png"), arguments.out
    session = about_one(whole, arguments)
    order = order_of(SheetOrder, arguments)
    require_tint(session, order.tint)
    with open_video_of(session, arguments.session) as video:
        content, problem = sheet_png(session, arguments.session, video, order)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    note(problem)
    return 0
