"""`keypose schema`: the JSON Schema of the files a person may write."""

from __future__ import annotations

import argparse

from keypose.app.cli.json_output import print_json
from keypose.tracker.body.body import Body
from keypose.tracker.session import Session


def run(arguments: argparse.Namespace) -> int:
    model = Body if arguments.kind == "body" else Session
    print_json(model.model_json_schema(), indent=2)
    return 0
