"""What long work of the page shares: orders read whole, answers as JSON that nothing keeps."""

from __future__ import annotations

from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from keypose.app.server.headers import headers_for
from keypose.tracker.errors import FormatError


async def read_body(request: Request, most: int, too_large: str) -> bytes:
    """What is sent; FormatError with the sentence `too_large` beyond `most` bytes."""
    content = bytearray()
    async for chunk in request.stream():
        content += chunk
        if len(content) > most:
            raise FormatError(too_large)
    return bytes(content)


def json_answer(content: Any, status: int = 200) -> Response:
    """An answer that is true now and may not be later."""
    headers = {**headers_for("data"), "Cache-Control": "no-store"}
    return JSONResponse(content, status, headers)
