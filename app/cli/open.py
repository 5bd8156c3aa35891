"""`keypose open`: the page, served on this computer alone."""

from __future__ import annotations

import argparse
import asyncio
import gc
import ipaddress
import signal
import socket
import sys
import webbrowser
from contextlib import suppress
from pathlib import Path

from keypose.app.cli.arguments import (
    note,
    order_of,
    session_file,
)
from keypose.app.document.defaults import read_defaults
from keypose.app.document.library import Library, usual_folders
from keypose.app.document.new import open_as_taken, open_with_reading
from keypose.app.document.open import copy_session
from keypose.app.orders.tracking import FilmTaken, said
from keypose.app.server.addresses import bind, host_in_url, is_wildcard, reachable
from keypose.app.server.links import Links
from keypose.app.server.server import Server
from keypose.tracker.errors import KeyposeError
from keypose.tracker.surface.new_session import Reading

PORTS_TRIED = 10
"""From the usual one on. A second Keypose is found at the same port again after a restart."""

_TUNNEL = """\
Keypose is made for one person on one computer: its page travels unencrypted, and whoever comes with
a link that it printed may do everything. From another computer, rather use an SSH tunnel,

    ssh -L {port}:127.0.0.1:{port} {host}

and open the address below without --host. To serve {host} all the same, add --let-others-in.
"""


def run(arguments: argparse.Namespace) -> int:
    _require_own(arguments)

    defaults = read_defaults()
    workspace = arguments.workspace or defaults.workspace
    # Before the rest is loaded: a tab that looks for its server waits instead of asking again.
    with _listener(arguments.host, arguments.port, defaults.port) as listener:
        shown_from = workspace if defaults.browser and not arguments.no_browser else None
        return _open(listener, arguments, workspace, shown_from)


def _open(
    listener: socket.socket,
    arguments: argparse.Namespace,
    workspace: Path,
    shown_from: Path | None,
) -> int:
    """Serve what was asked for until a signal asks to end."""
    gc.disable()  # what is loaded stays: looking through it again and again is a seventh of a start

    path = arguments.path
    if arguments.out is not None:
        path = _copy(path, arguments.out)
    library = Library(workspace, _roots(path))
    path = _with_reading(path, library, arguments)
    server = Server(library, _names(arguments.host), tuple(arguments.public_name))
    try:
        return _serve(server, listener, path, arguments, shown_from)
    finally:
        gc.enable()
        listener.close()
        server.stage.stop()


def _with_reading(
    path: Path | None, library: Library, arguments: argparse.Namespace
) -> Path | None:
    """What to open, once its film or meshes are read as a person says."""
    if taken := said(order_of(FilmTaken, arguments)):
        if path is None:
            raise KeyposeError("--recorded-fps and --deinterlace need a video or a session.")

        path = open_as_taken(path, library.session_for, taken)
    asked = (arguments.units, arguments.up, arguments.cameras)
    if asked == (None, None, None):
        return path
    if path is None:
        raise KeyposeError("--units, --up and --cameras need meshes to read.")

    reading = Reading(arguments.units, arguments.up)
    opened, news = open_with_reading(path, library.session_for, reading, arguments.cameras)
    note(" ".join(news) or None)
    return opened


def _serve(
    server: Server,
    listener: socket.socket,
    path: Path | None,
    arguments: argparse.Namespace,
    shown_from: Path | None,
) -> int:
    """Until a signal asks to end.

    shown_from: the workspace, from which a browser is led to the page; None to open none.
    """
    hang_up = getattr(signal, "SIGHUP", signal.SIGTERM)  # the terminal was closed
    for number in (signal.SIGINT, signal.SIGTERM, hang_up):
        signal.signal(number, lambda *_: server.ask_to_stop())

    loop = server.stage.loop
    if path is not None:
        asyncio.run_coroutine_threadsafe(server.store.open(path), loop).result()
    gc.freeze()
    gc.enable()
    server.listen(listener)
    links = Links(server.guard, reachable(arguments.host), arguments.public_name)
    links.print_first()
    print("Ctrl+C ends it; everything is saved as you go.", flush=True)
    if shown_from is not None:
        _show(links, shown_from)
    try:
        server.wait()
    finally:
        links.end()
    print("Keypose has ended; everything is saved.", flush=True)
    return 0


def _roots(path: Path | None) -> list[Path]:
    """The folders whose videos the page may list: where one is, where the opened file lies, and
    where people keep films."""
    beside = [] if path is None else [path.absolute().parent]

    return list(dict.fromkeys([Path.cwd(), *beside, *usual_folders(Path.home())]))


def _show(links: Links, workspace: Path) -> None:
    """Open in the person's browser; one that would take over the terminal is left alone."""
    try:
        browser = webbrowser.get()
    except webbrowser.Error:
        return
    if type(browser) is webbrowser.GenericBrowser:
        return
    try:
        browser.open(links.file(workspace).as_uri())
    except KeyposeError as error:
        note(f"{error} Open the link above in your browser.")


def _require_own(arguments: argparse.Namespace) -> None:
    """Only this computer's own address, or an explicit word that others may come."""
    if arguments.let_others_in:
        return
    if arguments.public_name:
        raise KeyposeError("--public-name lets others in: add --let-others-in.")
    if _is_own(arguments.host):
        return

    port = arguments.port or read_defaults().port
    print(_TUNNEL.format(host=arguments.host, port=port), file=sys.stderr)
    raise KeyposeError(
        f"{arguments.host} can be reached by others, which --host alone does not allow."
    )


def _is_own(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _names(host: str) -> tuple[str, ...]:
    """What a request may call this server besides the address at which it arrives."""
    return (socket.gethostname(),) if is_wildcard(host) else (host_in_url(host),)


def _listener(host: str, port: int | None, first: int) -> socket.socket:
    """A bound socket: the port asked for, or the first free one from the usual one on."""
    if port is not None:
        return bind(host, port)
    for usual in range(first, min(first + PORTS_TRIED, 65536)):
        with suppress(KeyposeError):  # it is taken
            return bind(host, usual)
    return bind(host, 0)


def _copy(path: Path | None, out: Path) -> Path:
    if path is None:
        raise KeyposeError("--out needs a session to copy.")
    try:
        session = session_file(str(path))
    except argparse.ArgumentTypeError as problem:
        raise KeyposeError(f"--out copies a session: {problem}.") from None
    return copy_session(session, out)
