"""`keypose track`: find the motion between the keyframes and save it beside the session."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_session,
    add_taken,
    add_work,
    names_of,
    taken_of,
)

if TYPE_CHECKING:
    from keypose.tracker.session import Session

_EXAMPLES = """\
  keypose track session.json
  keypose track session.json --quality preview --workers 2 --out try
  keypose track session.json --json > events.jsonl
  keypose track session.json --method paper --initial templates --leave-out right_hand
  keypose track session.json --cues brightness
  keypose track session.json --ahead forward
"""


def add(commands: Subcommands) -> None:
    details = (
        "Results are written beside the session. With --out, a copy of the session and the "
        "results are written to that folder and the session is not changed. Ctrl+C or SIGTERM "
        "keeps finished segments. A session that is open in the page is not tracked. The exit "
        "code is 1 when tracking was lost somewhere."
    )
    command = add_command(commands, "track", run, details, _EXAMPLES)
    add_session(command)
    of_session = "; default: the session's setting"
    command.add_argument("--method", choices=("keypose", "paper"), help=f"how{of_session}")
    command.add_argument(
        "--quality",
        choices=("full", "preview"),
        help=f"full, or less accurate and faster{of_session}",
    )
    command.add_argument(
        "--initial",
        choices=("auto", "templates", "import"),
        help="initial guess of each segment: the best of all (auto), template matching of head, "
        f"hands and feet, or an imported motion{of_session}",
    )
    command.add_argument(
        "--leave-out",
        metavar="PART",
        action="append",
        help=f"a part to exclude from template matching; can be repeated{of_session}",
    )
    command.add_argument(
        "--static-camera",
        choices=("yes", "no"),
        help=f"whether the camera is static{of_session}, by default detected in the video",
    )
    command.add_argument(
        "--cues",
        metavar="CUE,…",
        type=_cues,
        help="what to track from: brightness, keypoints or both, and silhouette, separated by"
        f" commas{of_session}. Keypoints need a person's body, silhouette needs a static "
        "camera; the published method uses brightness alone",
    )
    command.add_argument(
        "--network",
        choices=("full", "heavy"),
        help="network that finds keypoints: the bundled one (full), or a slower and more "
        f"accurate one that `keypose models add heavy` adds{of_session}",
    )
    command.add_argument(
        "--smooth",
        choices=("yes", "no"),
        help=f"whether the motion is smoothed in space as far as the video allows{of_session}",
    )
    command.add_argument(
        "--ahead",
        choices=("forward", "backward", "both"),
        help="instead, follow the body on from the last keyframe, back from the first, or both, as "
        "far as it is seen well; one keyframe is enough. The poses become drafts of the session",
    )
    add_taken(command)
    add_work(command)


def _cues(text: str) -> tuple[str, ...]:
    """Names of cues; the silhouette only judges the motion that the others lead to."""
    cues = names_of("brightness", "keypoints", "silhouette")(text)
    if cues == ("silhouette",):
        words = "silhouette cannot track alone; add brightness or keypoints"
        raise argparse.ArgumentTypeError(words)
    return cues


def _as_taken(session: Session, arguments: argparse.Namespace) -> Session:
    """The session as the film was taken, which its file says too, unless a copy is tracked."""
    from keypose.app.cli.outcome import locked_place
    from keypose.app.editor.camera import as_taken
    from keypose.tracker.storage.files import save_session

    if not (taken := taken_of(arguments)):
        return session
    session = as_taken(session, taken)
    if arguments.out is None:
        with locked_place(arguments) as place:
            save_session(session, place)
    return session


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.cli.outcome import track_and_save
    from keypose.app.jobs.rerun import require_trackable, with_settings
    from keypose.tracker.storage.files import load_session

    session = _as_taken(load_session(arguments.session), arguments)
    if arguments.ahead is None:
        require_trackable(session, arguments.session)
    still = None if arguments.static_camera is None else arguments.static_camera == "yes"
    asked = with_settings(
        session,
        arguments.method,
        arguments.quality,
        arguments.initial,
        arguments.leave_out,
        still,
        arguments.cues,
        arguments.network,
        None if arguments.smooth is None else arguments.smooth == "yes",
    )
    if arguments.ahead is not None:
        from keypose.app.cli.ahead import track_ahead_and_save

        return track_ahead_and_save(session, asked, arguments)
    return track_and_save(session, asked, arguments)
