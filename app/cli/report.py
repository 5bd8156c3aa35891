"""`keypose report`: what was found, as one page to read, print and send."""

from __future__ import annotations

import argparse

from keypose.app.cli.arguments import Subcommands, add_command, add_output, add_session
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import session_to_draw, video_if_there

_EXAMPLES = """\
  keypose report session.json --out report.html
  keypose report session.json --out report.html --overwrite
"""


def add(commands: Subcommands) -> None:
    details = (
        "It has the verdicts in words, rank and observability over time, the score of every "
        "pass, joint angles, the gait of one who walks, keyframes with their intervals, and "
        "pictures. The file is self-contained and needs no network. Without the video the "
        "pictures are left out."
    )
    command = add_command(commands, "report", run, details, _EXAMPLES)
    add_session(command)
    add_output(command, "FILE.html")


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.export.report.report import report_html
    from keypose.tracker.storage.atomic import write_file

    session, out = session_to_draw(arguments, "report", ".html", ".htm"), arguments.out
    with video_if_there(session, arguments.session, "the report has no pictures") as video:
        content = report_html(session, arguments.session, video)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    return 0
