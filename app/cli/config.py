"""`keypose config`: the defaults of this computer, and the file they are from."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from keypose.app.cli.json_output import print_json
from keypose.app.document.defaults import Defaults, defaults_path, read_defaults


def run(arguments: argparse.Namespace) -> int:
    path, defaults = defaults_path(), read_defaults()
    values = defaults.model_dump(mode="json")
    if arguments.json:
        names_set = sorted(defaults.model_fields_set)
        print_json({"path": str(path), "values": values, "from_file": names_set})
        return 0
    print(f"# {path}{_state(path)}")
    for name, field in Defaults.model_fields.items():
        source = "" if name in defaults.model_fields_set else " (built in)"
        print(f"{name} = {_toml(values[name])}  # {field.description}{source}")
    return 0


def _state(path: Path) -> str:
    return "" if path.exists() else ": not there, so everything is as built in"


def _toml(value: object) -> str:
    """A string, a number, true or false, or a list of strings: TOML writes them as JSON does."""
    return json.dumps(value, ensure_ascii=False)
