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
from typing import TYPE_CHECKING

from keypose.app.cli.arguments import (
    UNITS,
    UP_AXES,
    Subcommands,
    add_command,
    add_taken,
    file_name,
    host_name,
    note,
    session_file,
    taken_of,
    whole_number,
)
from keypose.tracker.errors import KeyposeError

if TYPE_CHECKING:
    from keypose.app.document.library import Library
    from keypose.app.server.links import Links
    from keypose.app.server.server import Server

PORTS_TRIED = 10
"""From the usual one on. A second Keypose is found at the same port again after a restart."""

_EXAMPLES = """\
  keypose open jump.mp4
  keypose open jump.keypose/session.json --port 8091 --no-browser
  keypose open sample_videos/balance/session.json --out out/balance
  keypose open scan --units cm --up +z
"""
_TUNNEL = """\
Keypose is made for one person on one computer: its page travels unencrypted, and whoever comes with
a link that it printed may do everything. From another computer, rather use an SSH tunnel,

    ssh -L {port}:127.0.0.1:{port} {host}

and open the address below without --host. To serve {host} all the same, add --let-others-in.
"""


def add(commands: Subcommands) -> None:
    details = (
        "Without a name, the page lets you choose. A new session is kept beside its video or "
        "meshes, and every change is saved at once. Ctrl+C ends the server."
    )
    command = add_command(commands, "open", run, details, _EXAMPLES)
    command.add_argument(
        "path",
        metavar="VIDEO|MESHES|SESSION",
        type=file_name,
        nargs="?",
        help="what to open; default: choose in the page",
    )
    command.add_argument(
        "--port",
        metavar="N",
        type=whole_number(0, 65535),
        default=None,
        help="port to serve; default: 8090, or the next free one; 0: any free one",
    )
    command.add_argument(
        "--no-browser", action="store_true", help="only print the address, do not open a browser"
    )
    command.add_argument(
        "--out",
        metavar="DIR",
        type=file_name,
        help="work on a copy of the session in DIR, which is created if missing",
    )
    command.add_argument(
        "--workspace",
        metavar="DIR",
        type=file_name,
        help="where uploads, samples and the list of sessions are stored; default: ~/Keypose, or "
        "as `keypose config` says",
    )
    of_files = "of new meshes; default: as the files state, else guessed"
    command.add_argument("--units", choices=UNITS, help=f"unit {of_files}")
    command.add_argument("--up", choices=UP_AXES, help=f"up axis, such as --up=-z, {of_files}")
    command.add_argument(
        "--cameras",
        metavar="FILE",
        type=file_name,
        help="JSON file with the calibrated cameras of new meshes",
    )
    add_taken(command)
    command.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to serve; default: 127.0.0.1, this computer alone",
    )
    command.add_argument(
        "--let-others-in", action="store_true", help="allow a --host that others can reach"
    )
    command.add_argument(
        "--public-name",
        metavar="HOST",
        type=host_name,
        action="append",
        default=[],
        help="name by which others reach this server, such as a proxy's, or this computer's "
        "with :PORT; can be repeated; needs --let-others-in",
    )


def run(arguments: argparse.Namespace) -> int:
    _require_own(arguments)
    from keypose.app.document.defaults import read_defaults

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
    from keypose.app.document.library import Library
    from keypose.app.server.server import Server

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
    """Return what to open, once its film or meshes are read as a person says."""
    if taken := taken_of(arguments):
        if path is None:
            raise KeyposeError("--recorded-fps and --deinterlace need a video or a session.")
        from keypose.app.document.new import open_as_taken

        path = open_as_taken(path, library.session_for, taken)
    given = (arguments.units, arguments.up, arguments.cameras)
    if given == (None, None, None):
        return path
    if path is None:
        raise KeyposeError("--units, --up and --cameras need meshes to read.")
    from keypose.app.document.new import open_with_reading
    from keypose.tracker.surface.new_session import Reading

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
    from keypose.app.server.addresses import reachable
    from keypose.app.server.links import Links

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
    from keypose.app.document.library import usual_folders

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
    from keypose.app.document.defaults import read_defaults

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
    """Return what a request may call this server besides the address at which it arrives."""
    from keypose.app.server.addresses import host_in_url, is_wildcard

    return (socket.gethostname(),) if is_wildcard(host) else (host_in_url(host),)


def _listener(host: str, port: int | None, first: int) -> socket.socket:
    """A bound socket: the port asked for, or the first free one from the usual one on."""
    from keypose.app.server.addresses import bind

    if port is not None:
        return bind(host, port)
    for usual in range(first, min(first + PORTS_TRIED, 65536)):
        with suppress(KeyposeError):  # it is taken
            return bind(host, usual)
    return bind(host, 0)


def _copy(path: Path | None, out: Path) -> Path:
    from keypose.app.document.open import copy_session

    if path is None:
        raise KeyposeError("--out needs a session to copy.")
    try:
        session = session_file(str(path))
    except argparse.ArgumentTypeError as problem:
        raise KeyposeError(f"--out copies a session: {problem}.") from None
    return copy_session(session, out)
