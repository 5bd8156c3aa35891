"""`keypose report`: what was found, as one page to read, print and send."""

from __future__ import annotations

import argparse

from app.cli.arguments import (
    Subcommands,
    add_command,
    add_json,
    add_overwrite,
    add_session,
    file_name,
)
from app.cli.json_output import print_written
from app.cli.views import session_to_draw, video_if_there

_EXAMPLES = """\
  keypose report session.json --out report.html
  keypose report session.json --out report.html --overwrite
"""


def add(commands: Subcommands) -> None:
    text = (
        "Write what tracking found into one HTML file: verdicts in words, rank and observability "
        "over time, the score of every pass, joint angles, keyframes with their intervals, and "
        "pictures. The file needs no other and no network. Where the video is missing, the "
        "pictures are left out."
    )
    command = add_command(commands, "report", run, text, _EXAMPLES)
    add_session(command)
    command.add_argument("--out", metavar="FILE.html", type=file_name, required=True)
    add_json(command)
    add_overwrite(command)


def run(arguments: argparse.Namespace) -> int:
    from app.export.report.report import report_html
    from tracker.storage.atomic import write_file

    session, out = session_to_draw(arguments, "report", ".html", ".htm"), arguments.out
    with video_if_there(session, arguments.session, "the report has no pictures") as video:
        content = report_html(session, arguments.session, video)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    return 0
