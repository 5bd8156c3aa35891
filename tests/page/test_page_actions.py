"""What the page's table of actions sends is what the program takes."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from keypose.app.editor.actions import ACTIONS
from tests.page.test_page_modules import SECONDS

HERE = Path(__file__).parent


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
