"""The line to a tab: what cannot be sent ends it, and is logged."""

from __future__ import annotations

import asyncio
from typing import Any, cast

import pytest
from starlette.websockets import WebSocket

from keypose.app.server.server import FAULT, _send
from keypose.app.store.tabs import Tab


class Line:
    """What a tab was sent, and how its line was closed."""

    def __init__(self) -> None:
        self.sent: list[str] = []
        self.closed: int | None = None

    async def send_text(self, text: str) -> None:
        self.sent.append(text)

    async def close(self, code: int) -> None:
        self.closed = code


def test_what_cannot_be_sent_closes_the_line_and_is_logged(
    capsys: pytest.CaptureFixture[str],
) -> None:
    tab, line = Tab(), Line()
    messages: list[dict[str, Any]] = [{"t": "reply", "words": "read"}, {"t": "reply", "\udcff": 1}]
    for message in messages:
        tab.send(message)
    asyncio.run(_send(cast(WebSocket, line), tab))
    assert len(line.sent) == 1
    assert line.closed == FAULT
    assert "Traceback" in capsys.readouterr().err
