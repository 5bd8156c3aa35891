"""Headers of responses: what a browser may do with a page, and from where it may load."""

from __future__ import annotations

from typing import Literal, TypeAlias

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
