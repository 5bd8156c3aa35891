"""The networks that find keypoints, as files: which there are, and where they lie.

They are known by their SHA-256 alone. A file that is damaged, or another network, is never read by
the library that runs it, which trusts what it reads. Of a network that a person added, a small file
beside it says what it is.
"""

from __future__ import annotations

import hashlib
import operator
import os
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError

from keypose.tracker.errors import KeypointError, listed
from keypose.tracker.files import read_regular, read_unshared
from keypose.tracker.session.settings import NetworkName, network_name

LARGEST_BYTES: Final = 256 * 2**20
"""RTMW-x, the largest network of joints in use, has some 230 MB."""

LARGEST_NOTE_BYTES: Final = 2**16
"""Of the note beside a network that says how it is read."""

JointKind: TypeAlias = Literal["movenet", "simcc", "maps", "rtmo"]
JointLayout: TypeAlias = Literal["COCO_17", "HALPE_26", "COCO_WHOLEBODY_133", "AP_10K"]
"""Names in `NETWORK_LAYOUTS` of those that networks may have: those of people are told apart by how
many joints each has."""
OF_ANIMALS: Final = "AP_10K"
_Pixels: TypeAlias = Annotated[int, Field(ge=32, le=2048)]
_Deviation: TypeAlias = Annotated[FiniteFloat, Field(gt=0)]


def _is_none(value: object) -> bool:
    return value is None


class Levels(BaseModel):
    """How a network is shown the levels of a picture, from 0 to 255: less the mean, over the
    deviation, of each channel in the order in which it sees them. rgb: red first, else blue."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    mean: tuple[FiniteFloat, FiniteFloat, FiniteFloat]
    std: tuple[_Deviation, _Deviation, _Deviation]
    rgb: bool


class JointHeads(BaseModel):
    """What a network of joints is shown, and what it answers with.

    layout: the order of its joints.  width, height: of its input.  outputs: in the order in which
    its kind is decoded.  levels: how it is shown a picture, where not as others of its kind.
    needs_fast: whether only the fast runtime may run it, since OpenCV would answer otherwise.
    finds: how many joints of the person in the test picture it finds; None where nobody looked.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: JointKind
    layout: JointLayout
    width: _Pixels
    height: _Pixels
    outputs: tuple[Annotated[str, Field(min_length=1, max_length=200)], ...]
    levels: Levels | None = Field(default=None, exclude_if=_is_none)
    needs_fast: bool = Field(default=False, exclude_if=operator.not_)
    finds: Annotated[int, Field(ge=0, le=17)] | None = Field(default=None, exclude_if=_is_none)

    @property
    def of_animals(self) -> bool:
        """Whether it sees animals in place of people."""
        return self.layout == OF_ANIMALS


class AddedNetwork(BaseModel):
    """A network that a person added, as the file beside it says."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: NetworkName
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    size_mb: Annotated[float, Field(ge=0, le=LARGEST_BYTES / 1e6)]
    heads: JointHeads


@dataclass(frozen=True)
class Model:
    """A network, and what it is known by.

    name: as it is chosen.  file: what its file is called, here and where it comes from.
    heads: of a network that sees joints alone and looks beside BlazePose; None of BlazePose, which
        gives depth and follows a body by itself.
    """

    name: str
    file: str
    sha256: str
    size_mb: float
    bundled: bool
    heads: JointHeads | None = None

    @property
    def of_animals(self) -> bool:
        """Whether it sees animals in place of people."""
        return self.heads is not None and self.heads.of_animals

    @property
    def path(self) -> Path:
        """Where it lies, or would lie."""
        folder = Path(__file__).with_name("models") if self.bundled else added_folder()
        return folder / self.file

    @property
    def is_here(self) -> bool:
        """Whether there is a file of it; what it holds is checked when it is opened."""
        return self.path.is_file()

    def skips_frames_at(self, fps: float) -> bool:
        """Whether keypoints of every second frame are enough in a film of this rate."""
        return self.heads is not None and fps >= LEAST_SKIPPED_FPS


LEAST_SKIPPED_FPS: Final = 40.0
"""At 60 frames a second the motion is as near to its marks by keypoints of every second frame as by
those of each, and drafts are as good; at 30 a walker's is 0.2 px farther."""

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
    heads=JointHeads(
        kind="movenet",
        layout="COCO_17",
        width=256,
        height=256,
        outputs=("heat", "reg", "center", "off"),
    ),
)
LIFTER: Final = Model(
    "lifter",
    "lifter.onnx",
    "d5018fb9912b30ffe39828e5db141a55de203a902eeadde0d90ff6aad22f877c",
    5.2,
    bundled=True,
)
"""It looks at keypoints, never at pictures, and cannot be chosen in place of the others."""
MODELS: Final = (THUNDER, FULL, HEAVY)


def cache_folder() -> Path:
    """This user's folder for what Keypose can make or fetch again; it may not exist yet."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "keypose"


def added_folder() -> Path:
    """Where added networks are kept."""
    return cache_folder() / "models"


def added_file(name: str) -> Path:
    """Where an added network lies; what is known of it, `.json`, lies beside it."""
    return added_folder() / f"{name}.onnx"


def added_names() -> tuple[str, ...]:
    """The names of all networks that a person added, in order."""
    return tuple(sorted(path.stem for path in added_folder().glob("*.json")))


def require_network_name(name: str) -> None:
    """KeypointError where a name cannot be a network's."""
    try:
        network_name(name)
    except ValueError as error:
        raise KeypointError(f"{name!r} cannot name a network: {error}.") from None


def find_model(name: str) -> Model:
    """The network of this name; KeypointError when there is none, or what is known of it is
    damaged."""
    require_network_name(name)
    for model in MODELS:
        if model.name == name:
            return model
    path = added_file(name)
    try:
        # unshared, since whoever could change the digest could exchange the network
        added = _added(read_unshared(path.with_suffix(".json"), LARGEST_NOTE_BYTES))
        return Model(name, path.name, added.sha256, added.size_mb, bundled=False, heads=added.heads)
    except FileNotFoundError:
        names = listed([*(model.name for model in MODELS), *added_names()])
        raise KeypointError(
            f"There is no network {name!r} here: choose from {names}, or add it by "
            f"`{adding_own(name)}`."
        ) from None
    except OSError as error:
        raise KeypointError(
            f"The network {name!r} cannot be read: {error.strerror or error}."
        ) from None
    except ValidationError:
        raise note_damaged(name) from None


def animal_model(chosen: str) -> Model:
    """The network that sees animals: the one that is chosen where it does, else the first that was
    added; KeypointError where there is none."""
    for model in (find_model(chosen), *added_models()):
        if model.of_animals:
            return model
    raise KeypointError(
        "Drafts of an animal need a network of animals: add one trained on AP-10K by "
        "`keypose models add NAME --from FILE --sha256 DIGEST --animals`."
    )


def note_damaged(name: str) -> KeypointError:
    """What is said where the file beside an added network cannot be right."""
    return KeypointError(
        f"What is known of the network {name!r} is damaged: run `keypose models remove {name}` "
        "and add it again."
    )


def added_models() -> tuple[Model, ...]:
    """The networks that a person added, without those of which what is known is damaged."""
    models = []
    for name in added_names():
        with suppress(KeypointError):
            models.append(find_model(name))
    return tuple(models)


_added = lru_cache(maxsize=32)(AddedNetwork.model_validate_json)
"""What the file beside an added network says, by its content."""


def verified(model: Model) -> bytes:
    """A network's file, which has been checked to be exactly that network: what is checked is what
    is run, whatever becomes of the file meanwhile.

    KeypointError in one sentence when it is missing or damaged.
    """
    again = f"run `{adding(model)}`"
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
    return content


def adding(model: Model) -> str:
    """The command that brings a network here; those that come with Keypose, with it."""
    if model.bundled:
        return "pip install --force-reinstall keypose"
    return adding_own(model.name) if model.heads else f"keypose models add {model.name}"


def adding_own(name: str) -> str:
    """The command that adds a network of a person's own under this name."""
    return f"keypose models add {name} --from FILE --sha256 DIGEST"


def is_content(model: Model, content: bytes) -> bool:
    """Whether these bytes are the network's file."""
    return hashlib.sha256(content).hexdigest() == model.sha256
