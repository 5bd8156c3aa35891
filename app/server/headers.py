"""Set the headers of responses, and answer long work's orders as JSON that nothing keeps."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from keypose.tracker.errors import FormatError

Kind: TypeAlias = Literal["page", "view", "data"]

_PAGE_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; font-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'{socket}; frame-src 'self'; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)
_VIEW_POLICY = (  # viser's page is one file that unpacks and starts itself
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "worker-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
    "font-src 'self' data: blob:; img-src 'self' data: blob:; "
    "connect-src 'self'{socket} data: blob:; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'"
)
_DATA_POLICY = "default-src 'none'; frame-ancestors 'self'"


def headers_for(kind: Kind, host: str = "") -> dict[str, str]:
    """Security headers for our page, for viser's page inside it, or for anything else.

    `host` is the request's Host, already examined: some browsers want the socket's scheme named.
    """
    common = {
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
        "X-Frame-Options": "SAMEORIGIN",
    }
    socket = f" ws://{host}" if host else ""
    policy = {"page": _PAGE_POLICY, "view": _VIEW_POLICY, "data": _DATA_POLICY}[kind]
    return {**common, "Content-Security-Policy": policy.format(socket=socket)}


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
