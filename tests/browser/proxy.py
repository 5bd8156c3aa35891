"""What lies between browser and server, as a proxy: it can be cut, and names can lead elsewhere."""

from __future__ import annotations

import re
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

LONGEST_HEAD = 1 << 16
Address = tuple[str, int]


class Proxy:
    """A proxy for a browser. What passes is not looked at; one request per connection."""

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._leads: dict[str, Address] = {}
        self._lines: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._whole = True
        threading.Thread(target=self._accept, daemon=True).start()

    @property
    def address(self) -> str:
        """For the browser's settings."""
        return f"http://127.0.0.1:{self._listener.getsockname()[1]}"

    def lead(self, host: str, to: str) -> None:
        """From now on this host and port is that one, as a name server may have it."""
        name, port = to.split(":")
        self._leads[host] = (name, int(port))

    def cut(self) -> None:
        """Every line breaks, and none can be had, until it is mended."""
        with self._lock:
            self._whole = False
            for line in self._lines:
                with suppress(OSError):
                    line.shutdown(socket.SHUT_RDWR)

    def mend(self) -> None:
        with self._lock:
            self._whole = True

    def remove(self) -> None:
        self.cut()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                browser, _ = self._listener.accept()
                threading.Thread(target=self._serve, args=(browser,), daemon=True).start()

    def _serve(self, browser: socket.socket) -> None:
        with suppress(OSError), browser:
            head = _head(browser)
            host = _host(head)
            if not host:
                return
            server = socket.create_connection(self._address(host))
            with server:
                if not self._hold(browser, server):
                    return
                if head.startswith(b"CONNECT "):
                    browser.sendall(b"HTTP/1.1 200 Connected\r\n\r\n")
                else:
                    server.sendall(_direct(head))
                back = threading.Thread(target=_pump, args=(server, browser), daemon=True)
                back.start()
                _pump(browser, server)
                back.join()
                with self._lock:
                    self._lines -= {browser, server}

    def _hold(self, *lines: socket.socket) -> bool:
        """Whether they may be used: not while the cable is cut."""
        with self._lock:
            if self._whole:
                self._lines.update(lines)
            return self._whole

    def _address(self, host: str) -> Address:
        name, _, port = host.partition(":")
        return self._leads.get(host, (name, int(port or 80)))


@contextmanager
def proxy() -> Iterator[Proxy]:
    """A proxy, while it is needed."""
    relay = Proxy()
    try:
        yield relay
    finally:
        relay.remove()


def _head(line: socket.socket) -> bytes:
    """The first request, as far as it has come when its head is whole."""
    head = b""
    while b"\r\n\r\n" not in head and len(head) < LONGEST_HEAD:
        more = line.recv(LONGEST_HEAD)
        if not more:
            return b""
        head += more
    return head


def _host(head: bytes) -> str:
    """The host and port that a request is for."""
    found = re.match(rb"CONNECT (\S+)|[A-Z]+ http://([^/ ]+)", head)
    return (found[1] or found[2]).decode() if found else ""


def _direct(head: bytes) -> bytes:
    """As the browser would ask the server itself."""
    head = re.sub(rb"^([A-Z]+) http://[^/ ]+", rb"\1 ", head, count=1)
    return head.replace(b"Proxy-Connection: keep-alive", b"Connection: close", 1)


def _pump(source: socket.socket, target: socket.socket) -> None:
    """All that comes, until either side has had enough."""
    with suppress(OSError):
        while chunk := source.recv(1 << 16):
            target.sendall(chunk)
    with suppress(OSError):
        target.shutdown(socket.SHUT_WR)
