"""Orders of tracking: how a session is tracked this time, and how its film was taken."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

from keypose.app.orders.order import option, options_of
from keypose.app.orders.values import Choice, FrameRange, Misread, Name, Rate, Value

if TYPE_CHECKING:
    from keypose.tracker.session.settings import Cue, Initial, MethodName, NetworkName, Quality

_OF_SESSION: Final = "; default: the session's setting"
CUES: Final = ("brightness", "keypoints", "depth", "silhouette")
_NETWORK: Final = (
    "network that finds keypoints: thunder together with full, full alone, heavy, which is slower "
    "and has to be added, or one of your own, together with full; `keypose models` adds and lists "
    "them"
)


@dataclass(frozen=True, eq=False, repr=False)
class YesNo(Value):
    """Yes or no, where leaving it out means neither."""

    metavar: str | None = "{yes,no}"

    def read(self, text: str) -> bool:
        return Choice(names=("yes", "no")).read(text) == "yes"


@dataclass(frozen=True, eq=False, repr=False)
class _Cues(Value):
    """Names of cues; depth and silhouette alone lead to no motion."""

    metavar: str | None = "CUE,…"

    def read(self, text: str) -> tuple[str, ...]:
        asked = [Choice(names=CUES).read(word.strip()) for word in text.split(",")]
        if not {"brightness", "keypoints"} & set(asked):
            raise Misread(f"{asked[0]} cannot track alone; add brightness or keypoints")
        if "depth" in asked and "keypoints" not in asked:
            raise Misread("depth is lifted from keypoints; add keypoints")
        return tuple(cue for cue in CUES if cue in asked)


@dataclass(frozen=True, eq=False, repr=False)
class _Network(Value):
    """A network's name; whether it is here, tracking says."""

    metavar: str | None = "NAME"

    def read(self, text: str) -> str:
        from keypose.tracker.session.settings import network_name  # not for a command's help

        try:
            return network_name(text)
        except ValueError as error:
            raise Misread(str(error)) from None


@dataclass(frozen=True, eq=False, repr=False)
class _Recorded(Value):
    metavar: str | None = "N"

    def read(self, text: str) -> float:
        return float(Rate(None, Fraction(1, 1000), 1_000_000).read(text))


@dataclass(frozen=True)
class TrackOrder:
    """How a session is tracked this time; the session's own settings where nothing is said."""

    method: MethodName | None = option(Choice(names=("keypose", "paper")), f"how{_OF_SESSION}")
    quality: Quality | None = option(
        Choice(names=("full", "preview")), f"full, or less accurate and faster{_OF_SESSION}"
    )
    initial: Initial | None = option(
        Choice(names=("auto", "templates", "import")),
        "initial guess of each segment: the best of all (auto), template matching of head, hands "
        f"and feet, or an imported motion{_OF_SESSION}",
    )
    left_out: tuple[str, ...] | None = option(
        Name("PART"),
        f"a part to exclude from template matching; can be repeated{_OF_SESSION}",
        flag="leave-out",
        repeated=True,
    )
    static_camera: bool | None = option(
        YesNo(), f"whether the camera is static{_OF_SESSION}, by default detected in the video"
    )
    find_camera: bool | None = option(
        YesNo(),
        "whether the motion of a camera that moves is found first, where it is not known"
        f"{_OF_SESSION}",
    )
    cues: tuple[Cue, ...] | None = option(
        _Cues(),
        "what to track from: brightness, keypoints or both, depth, lifted from a second of "
        "keypoints, and silhouette, separated by commas"
        f"{_OF_SESSION}. Keypoints need a person's body, silhouette that or a static camera; the "
        "published method uses brightness alone",
    )
    network: NetworkName | None = option(_Network(), f"{_NETWORK}{_OF_SESSION}")
    smooth: bool | None = option(
        YesNo(), f"whether the motion is smoothed in space as far as the video allows{_OF_SESSION}"
    )


@dataclass(frozen=True)
class Within:
    """Between which frames a command works."""

    frames: tuple[int, int] | None = option(
        FrameRange(), "first and last frame to work between; default: all"
    )


AS_SET: Final = TrackOrder()
"""As each session is set."""


@dataclass(frozen=True)
class DraftOrder:
    """How the person of a draft is found."""

    network: NetworkName | None = option(
        _Network(), f"{_NETWORK}, and the session keeps it; default: as `keypose config` says"
    )


@dataclass(frozen=True)
class FilmTaken:
    """How a film was taken, where its file does not say so."""

    recorded_fps: float | None = option(
        _Recorded(),
        "frames a second at which it was recorded, such as 240 of slow motion, or at which a "
        "folder's images were taken: times and speeds follow it, and the session keeps it; "
        "default: the file's rate, 30 for images",
    )
    deinterlace: bool | None = option(
        YesNo(),
        "whether frames that are marked interlaced are deinterlaced, which the session keeps; "
        "default: yes",
    )


def said(order: object) -> dict[str, Any]:
    """What an order says, by its fields; what it leaves out is not there."""
    values = {name: getattr(order, name) for name in options_of(type(order))}
    return {name: value for name, value in values.items() if value is not None}
