"""`keypose schema`: the JSON Schema of the files a person may write."""

from __future__ import annotations

import argparse

from keypose.app.cli.arguments import Subcommands, add_command
from keypose.app.cli.json_output import print_json

_EXAMPLES = """\
  keypose schema session > session.schema.json
  keypose schema body
"""


def add(commands: Subcommands) -> None:
    command = add_command(commands, "schema", run, "", _EXAMPLES)
    command.add_argument("kind", choices=("body", "session"), help="which file")


def run(arguments: argparse.Namespace) -> int:
    from keypose.tracker.body.body import Body
    from keypose.tracker.session import Session

    model = Body if arguments.kind == "body" else Session
    print_json(model.model_json_schema(), indent=2)
    return 0
