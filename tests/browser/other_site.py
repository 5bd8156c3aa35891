"""A server of somebody else: its pages are what a hostile site would show."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

PAGE = b"<!doctype html><title>Somebody else</title>"


class OtherSite:
    """`visits` are the addresses it was asked for, `cookies` what it was sent with each."""

    def __init__(self) -> None:
        visits: list[str] = []
        cookies: list[str] = []

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                visits.append(self.path)
                cookies.append(self.headers.get("Cookie", ""))
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.send_header("Content-Length", str(len(PAGE)))
                self.end_headers()
                self.wfile.write(PAGE)

            def log_message(self, *_: object) -> None:
                pass

        self.visits = visits
        self.cookies = cookies
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)

    @property
    def port(self) -> int:
        return int(self.server.server_address[1])


@contextmanager
def other_site() -> Iterator[OtherSite]:
    """Somebody else's server, while it is needed."""
    other = OtherSite()
    thread = threading.Thread(target=other.server.serve_forever)
    thread.start()
    try:
        yield other
    finally:
        other.server.shutdown()
        thread.join()
        other.server.server_close()
