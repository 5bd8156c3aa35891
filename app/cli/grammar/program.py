"""Grammar of the commands of the program itself: the page, schemas, defaults, checks."""

from __future__ import annotations

from keypose.app.cli.arguments import (
    UNITS,
    UP_AXES,
    Subcommands,
    add_command,
    add_json,
    add_order,
    file_name,
    host_name,
    typed,
)
from keypose.app.orders.tracking import FilmTaken
from keypose.app.orders.values import Whole

_OPEN_EXAMPLES = """\
  keypose open jump.mp4
  keypose open jump.keypose/session.json --port 8091 --no-browser
  keypose open sample_videos/balance/session.json --out out/balance
  keypose open scan --units cm --up +z
"""


def add_open(commands: Subcommands) -> None:
    details = (
        "Without a name, the page lets you choose. A new session is kept beside its video or "
        "meshes, and every change is saved at once. Ctrl+C ends the server."
    )
    command = add_command(commands, "open", details, _OPEN_EXAMPLES)
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
        type=typed(Whole(least=0, most=65535)),
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
    add_order(command, FilmTaken)
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


_SCHEMA_EXAMPLES = """\
  keypose schema session > session.schema.json
  keypose schema body
"""


def add_schema(commands: Subcommands) -> None:
    command = add_command(commands, "schema", "", _SCHEMA_EXAMPLES)
    command.add_argument("kind", choices=("body", "session"), help="which file")


_CONFIG_EXAMPLES = """\
  keypose config
  keypose config --json
"""


def add_config(commands: Subcommands) -> None:
    details = (
        "What is printed is TOML: write the lines that you want to change into the file that is "
        "named first. The command line goes before a session, a session before this file, and "
        "the file before what is built in. The variable KEYPOSE_CONFIG names another file."
    )
    command = add_command(commands, "config", details, _CONFIG_EXAMPLES)
    add_json(command)


_DOCTOR_EXAMPLES = """\
  keypose doctor
  keypose doctor --json
  keypose doctor --workspace /data/keypose
"""


def add_doctor(commands: Subcommands) -> None:
    details = (
        "Checks the libraries, video coding, cores and memory, folders, compiled loops, networks, "
        "the port, the browser and optional parts. Nothing is changed. The exit code is 1 when "
        "something that Keypose needs does not work."
    )
    command = add_command(commands, "doctor", details, _DOCTOR_EXAMPLES)
    command.add_argument(
        "--workspace", metavar="DIR", type=file_name, help="the workspace to check, as for `open`"
    )
    add_json(command)


_COMPLETION_EXAMPLES = """\
  keypose completion bash > ~/.local/share/bash-completion/completions/keypose
  keypose completion zsh > ~/.zfunc/_keypose
  keypose completion fish > ~/.config/fish/completions/keypose.fish
"""


def add_completion(commands: Subcommands) -> None:
    """The command's `grammar` is to be set to what makes the parser that is to be completed."""
    details = (
        "Written to the file of the examples, it works in the next shell, without starting Python. "
        "zsh looks into ~/.zfunc where ~/.zshrc says `fpath+=~/.zfunc` before `compinit`."
    )
    command = add_command(commands, "completion", details, _COMPLETION_EXAMPLES)
    command.add_argument("shell", choices=("bash", "zsh", "fish"), help="which shell")
