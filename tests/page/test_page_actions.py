"""What the page's table of actions sends is what the program takes."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import get_args

from keypose.app.editor.actions import ACTIONS, MESSAGES
from keypose.app.editor.message import Look
from tests.page.test_page_modules import SECONDS

HERE = Path(__file__).parent
ENDS = ("end_stroke", "cancel_stroke")


def test_every_message_of_the_table_is_one_that_the_program_knows(node: str) -> None:
    run = subprocess.run(
        [node, "messages.js"],
        cwd=HERE,
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=True,
    )
    messages = json.loads(run.stdout)
    assert len(messages) > 20
    for name, message in messages.items():
        assert ACTIONS.validate_python(message).do == message["do"], name


def test_the_page_waits_with_edits_and_not_with_looks() -> None:
    text = (HERE.parents[1] / "static" / "store" / "edits.js").read_text("utf-8")
    looks = text.partition("const LOOKS = {")[2].partition("};")[0]
    listed = text.partition("const NO_EDITS = new Set([")[2].partition("]);")[0]
    named = {*re.findall(r"^  (\w+): \(", looks, re.MULTILINE), *re.findall(r"'(\w+)'", listed)}
    for kind in MESSAGES:
        for word in get_args(kind.model_fields["do"].annotation):
            assert (word in named) == issubclass(kind, Look) or word in ENDS, word
