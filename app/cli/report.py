"""`keypose report`: what was found, as one page to read, print and send."""

from __future__ import annotations

import argparse

from keypose.app.cli.bodies import about_drawn
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import session_to_draw, video_if_there
from keypose.app.export.report.report import report_html
from keypose.tracker.storage.atomic import write_file


def run(arguments: argparse.Namespace) -> int:
    whole, out = session_to_draw(arguments, "report", ".html", ".htm"), arguments.out
    session, alone = about_drawn(whole, arguments)
    with video_if_there(session, arguments.session, "the report has no pictures") as video:
        content = report_html(session, arguments.session, video, alone=alone)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    return 0
