"""Find the addresses at which this computer is reached, and listen at one."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Iterator
from contextlib import suppress
from typing import TypeAlias

from keypose.tracker.errors import KeyposeError

Address: TypeAlias = ipaddress.IPv4Address | ipaddress.IPv6Address

_ELSEWHERE = {
    # No packet is sent: these only ask which of our addresses leads to such networks.
    socket.AF_INET: ("192.0.2.1", "10.255.255.254", "172.31.255.254", "192.168.255.254"),
    socket.AF_INET6: ("2001:db8::1", "fd00::ffff"),
}


def is_wildcard(host: str) -> bool:
    """Whether a server at this host listens at every address of the computer."""
    address = parse(host)
    return address is not None and address.is_unspecified


def parse(text: str) -> Address | None:
    """The address a text says, an IPv4 address that is written as IPv6 included; None for names."""
    try:
        address = ipaddress.ip_address(text.strip("[]").partition("%")[0])
    except ValueError:
        return None
    return getattr(address, "ipv4_mapped", None) or address


def host_in_url(host: str) -> str:
    """A host as it stands in an address."""
    return f"[{host}]" if ":" in host else host


def reachable(host: str) -> list[str]:
    """What to write instead of the host that a server listens at: every address and name
    known to lead there, this computer's own first.

    A wildcard stands for all addresses. Python's library cannot list those: these are the ones that
    lead into the usual networks, and those the computer's name stands for.
    """
    if not is_wildcard(host):
        return [host]
    families = [socket.AF_INET] if "." in host else [socket.AF_INET, socket.AF_INET6]
    hosts = ["127.0.0.1", *(a for family in families for a in _own(family))]
    name = socket.gethostname()
    named = {str(parse(a)) for family in families for a in _resolved(name, family)}
    if named and named <= set(hosts):
        hosts.append(name)
    return list(dict.fromkeys(hosts))


def _own(family: socket.AddressFamily) -> Iterator[str]:
    leading = (_towards(place, family) for place in _ELSEWHERE[family])
    for text in (*leading, *_resolved(socket.gethostname(), family)):
        address = parse(text)
        if address is not None and not address.is_link_local and _can_bind(str(address), family):
            yield str(address)


def _towards(place: str, family: socket.AddressFamily) -> str:
    with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as probe:
        probe.connect((place, 9))
        return str(probe.getsockname()[0])
    return ""


def _resolved(name: str, family: socket.AddressFamily) -> list[str]:
    try:
        return [str(entry[4][0]) for entry in socket.getaddrinfo(name, None, family)]
    except (OSError, UnicodeError):  # a computer whose name stands for nothing
        return []


def _can_bind(text: str, family: socket.AddressFamily) -> bool:
    with suppress(OSError), socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.bind((text, 0))
        return True
    return False


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
