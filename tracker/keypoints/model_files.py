"""The networks that find keypoints, as files: which there are, and where they lie.

They are known by their SHA-256 alone. A file that is damaged, or another network, is never read by
the library that runs it, which trusts what it reads.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from keypose.tracker.errors import KeypointError, listed
from keypose.tracker.files import read_regular

LARGEST_BYTES: Final = 64 * 2**20


@dataclass(frozen=True)
class Model:
    """A network, and what it is known by.

    name: as it is chosen.  file: its name, in the package it comes from too.
    follows: whether it is BlazePose, which gives depth and follows a body by itself; others see
        joints alone and look beside it.
    """

    name: str
    file: str
    sha256: str
    size_mb: float
    bundled: bool
    follows: bool = True

    @property
    def path(self) -> Path:
        """Return where it lies, or would lie."""
        folder = Path(__file__).with_name("models") if self.bundled else added_folder()
        return folder / self.file

    @property
    def is_here(self) -> bool:
        """Return whether there is a file of it; what it holds is checked when it is opened."""
        return self.path.is_file()


FULL: Final = Model(
    "full",
    "pose_landmark_full.tflite",
    "e9a5c5cb17f736fafd4c2ec1da3b3d331d6edbe8a0d32395855aeb2cdfd64b9f",
    6.4,
    bundled=True,
)
HEAVY: Final = Model(
    "heavy",
    "pose_landmark_heavy.tflite",
    "59e42d71bcd44cbdbabc419f0ff76686595fd265419566bd4009ef703ea8e1fe",
    27.7,
    bundled=False,
)
THUNDER: Final = Model(
    "thunder",
    "movenet_thunder.onnx",
    "9d0b5d2161c408f44bae30f5ba337affa4db675407285d1379a8af6c860d9675",
    12.5,
    bundled=True,
    follows=False,
)
MODELS: Final = (THUNDER, FULL, HEAVY)


def cache_folder() -> Path:
    """This user's folder for what Keypose can make or fetch again; it may not exist yet."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "keypose"


def added_folder() -> Path:
    """Return where added networks are kept."""
    return cache_folder() / "models"


def find_model(name: str) -> Model:
    """The network of this name; KeypointError when there is none."""
    for model in MODELS:
        if model.name == name:
            return model
    names = listed([model.name for model in MODELS])
    raise KeypointError(f"There is no network {name!r}: choose from {names}.")


def verified(model: Model) -> Path:
    """The path of a network's file, which has been checked to hold exactly that network.

    KeypointError in one sentence when it is missing or damaged.
    """
    again = (
        "install Keypose again" if model.bundled else f"run `keypose models add {model.name}`"
    )  # fmt: skip
    try:
        content = read_regular(model.path, LARGEST_BYTES)
    except FileNotFoundError:
        raise KeypointError(f"The {model.name} network is not installed: {again}.") from None
    except OSError as error:
        raise KeypointError(
            f"The network {str(model.path)!r} cannot be read: {error.strerror or error}; {again}."
        ) from None
    if not is_content(model, content):
        raise KeypointError(
            f"{str(model.path)!r} is damaged or is not the {model.name} network: {again}."
        )
    return model.path


def is_content(model: Model, content: bytes) -> bool:
    """Return whether these bytes are the network's file."""
    return hashlib.sha256(content).hexdigest() == model.sha256
