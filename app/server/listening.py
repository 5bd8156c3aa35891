"""A listening socket."""

from __future__ import annotations

import socket

from keypose.tracker.errors import KeyposeError


def bind(host: str, port: int) -> socket.socket:
    """A bound socket; KeyposeError in one sentence when the port cannot be had.

    Made with its protocol named, or asyncio would leave Nagle's delay on: 40 ms a message.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    if host == "::" and socket.has_dualstack_ipv6():  # not every system listens at both unasked
        listener.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
    try:
        listener.bind((host, port))
        listener.listen(100)  # from now on a browser that comes early waits
    except OSError as error:
        listener.close()
        raise KeyposeError(
            f"Port {port} of {host} cannot be used: {error.strerror}; choose another with --port."
        ) from None
    return listener
