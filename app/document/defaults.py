"""What a person has chosen once: how new sessions begin, where uploads go, which port serves.

They are lines of `config.toml` in the platform's own place for settings:

    workspace = "~/Movies/Keypose"
    body = "adult_female"
    quality = "preview"

A session keeps what it began with, so it means the same on every computer: the command line goes
before the session, the session before this file, and this file before what is built in.
"""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Annotated, Any, Final

from platformdirs import user_config_path
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.errors import KeyposeError, one_sentence
from keypose.tracker.files import read_regular
from keypose.tracker.session.settings import (
    ALL_CUES,
    Cues,
    MethodName,
    NetworkName,
    Quality,
    TrackSettings,
)

LARGEST_BYTES: Final = 64 * 1024
"""Of the file of defaults."""
FIRST_PORT: Final = 8090
"""The port that is tried first."""


def _expanded(path: Path) -> Path:
    try:
        path = path.expanduser()
    except RuntimeError as error:
        raise ValueError(str(error)) from None
    if not path.is_absolute():
        raise ValueError("write the whole path, or one that begins with ~")
    return path


def _require_preset(name: str) -> str:
    if name not in PRESETS:
        raise ValueError(f"there is no body {name!r}; choose from {', '.join(PRESETS)}")
    return name


class Defaults(BaseModel):
    """The values that count where neither the command line nor a session says otherwise."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    workspace: Annotated[Path, AfterValidator(_expanded)] = Field(
        default=Path("~/Keypose"),
        validate_default=True,
        description="where uploads, samples and the list of sessions are stored",
    )
    port: Annotated[int, Field(ge=0, le=65535)] = Field(
        default=FIRST_PORT, description="the page is served there, or at the next free one"
    )
    browser: bool = Field(default=True, description="whether `keypose open` opens a browser")
    body: Annotated[str, AfterValidator(_require_preset)] = Field(
        default="adult_male", description="of new sessions"
    )
    method: MethodName = Field(default="keypose", description="of new sessions of a video")
    quality: Quality = Field(default="full", description="of new sessions of a video")
    cues: Cues = Field(default=ALL_CUES, description="of new sessions of a video")
    network: NetworkName = Field(default="thunder", description="of new sessions of a video")
    smooth: bool = Field(default=True, description="of new sessions of a video")

    @property
    def track_settings(self) -> TrackSettings:
        """How a new session of a video is tracked."""
        return TrackSettings(
            method=self.method,
            quality=self.quality,
            cues=self.cues,
            network=None if self.network == "full" else self.network,
            smooth=self.smooth,
        )


def defaults_path() -> Path:
    """The file; it need not exist. The variable KEYPOSE_CONFIG names another one."""
    named = os.environ.get("KEYPOSE_CONFIG")
    return Path(named) if named else user_config_path("keypose", appauthor=False) / "config.toml"


def read_defaults() -> Defaults:
    """What the file says, and what is built in where it says nothing.

    KeyposeError in one sentence when it cannot be read or says what cannot be.
    """
    path = defaults_path()
    try:
        return Defaults.model_validate(_content(path))
    except ValidationError as error:
        raise KeyposeError(f"{path}: {_sentence(error)}") from None


def _content(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(read_regular(path, LARGEST_BYTES).decode("utf-8"))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise KeyposeError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, RecursionError) as error:  # not TOML alone: a number of too many digits
        raise KeyposeError(f"{path} is not TOML: {error}.") from None


def _sentence(error: ValidationError) -> str:
    """The first problem; a name that is not known comes with those that are."""
    first = error.errors(include_url=False)[0]
    if first["type"] != "extra_forbidden":
        return one_sentence(error)
    settings = ", ".join(Defaults.model_fields)
    return f"there is no setting {first['loc'][0]!r}; the settings are {settings}."
