"""`keypose doctor`: what of this computer Keypose needs, whether it is there, and what to do."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import asdict
from typing import TYPE_CHECKING

from keypose.app.cli.arguments import Subcommands, add_command, add_json, file_name
from keypose.app.cli.json_output import print_json

if TYPE_CHECKING:
    from keypose.app.cli.checks import Finding

FOUND_AN_ERROR = 1

_EXAMPLES = """\
  keypose doctor
  keypose doctor --json
  keypose doctor --workspace /data/keypose
"""
_MARKS = {"ok": "ok", "note": "note", "warning": "warning", "error": "ERROR"}


def add(commands: Subcommands) -> None:
    summary = "Check this computer: what is missing, and what to do about it"
    details = (
        "Checks the libraries, video coding, cores and memory, folders, compiled loops, networks, "
        "the port, the browser and optional parts. Nothing is changed. The exit code is 1 when "
        "something that Keypose needs does not work."
    )
    command = add_command(commands, "doctor", run, summary, details, _EXAMPLES)
    command.add_argument(
        "--workspace", metavar="DIR", type=file_name, help="the workspace to check, as for `open`"
    )
    add_json(command)


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.cli.checks import examine

    findings = []
    for finding in examine(arguments.workspace):
        findings.append(finding)
        if not arguments.json:
            _print(finding)
    is_well = all(finding.state != "error" for finding in findings)
    if arguments.json:
        print_json({"well": is_well, "findings": [asdict(finding) for finding in findings]})
    else:
        print(_summary(findings))
    return 0 if is_well else FOUND_AN_ERROR


def _print(finding: Finding) -> None:
    print(f"{_MARKS[finding.state]:8}{finding.name}: {finding.words}")
    if finding.remedy:
        print(f"{'':8}  {finding.remedy}")
    sys.stdout.flush()


def _summary(findings: list[Finding]) -> str:
    count = Counter(finding.state for finding in findings)
    if count["error"]:
        return f"Keypose cannot work here yet: see the {count['error']} marked ERROR."
    if count["warning"]:
        return f"Keypose works here, with {count['warning']} limited: see what is marked warning."
    return "Keypose works here."
