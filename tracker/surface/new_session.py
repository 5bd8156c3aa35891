"""Begin a session about surfaces: guess what the files do not say, and report the guess."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.references import Surface
from keypose.tracker.session.settings import Units, UpAxis
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.files.sequence import MeshSequence
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.placing import METRES, Placement

_PERSON: Final[tuple[tuple[float, float, Units], ...]] = (
    (0.3, 3.0, "m"),
    (30.0, 300.0, "cm"),
    (300.0, 3000.0, "mm"),
)
_BY_FAR: Final = 1.5


def guess_units(longest: float) -> Units | None:
    """The unit in which a surface whose longest extent is this is about as large as a person.

    A guess: 40 may be 40 cm of a child's arm or 40 m of a house. None where no unit fits.
    """
    fitting = [unit for least, most, unit in _PERSON if least <= longest < most]
    return fitting[0] if fitting else None


def guess_up(mesh: SurfaceMesh) -> UpAxis:
    """The axis along which a surface is longest; x only where it is so by far.

    A guess, right for people who stand; it cannot know who hangs upside down or lies. Hardly any
    file has x upward, but arms spread along it often reach farther than a person is tall.
    """
    x, y, z = mesh.extent
    if x > _BY_FAR * max(y, z):
        return "+x"
    return "+y" if y >= z else "+z"


WIDTH = 960
HEIGHT = 720
"""Pixels of the camera that looks at surfaces that no camera took."""
FIELD_OF_VIEW = math.radians(35.0)
FILLED_HEIGHT = 0.70
FILLED_WIDTH = 0.85
"""The most of the picture that the surfaces take, wherever they move to …"""
LEAST_HEIGHT = 0.35
"""… unless the first one then took less than this."""
LOOKED_AT = 5
"""Steps that are read to see how far the surfaces move."""
MOST_UNUSABLE = 50
"""Steps that are tried until one has a surface that can be used."""
PERSON_M = 1.7
"""Height of a person, by which the unit of the meshes is guessed."""
NEAREST_M = 0.3
"""Depth of the nearest surface for that camera."""
FPS = 25.0
"""Steps a second where nobody says how many."""

Box: TypeAlias = tuple[Array, Array]
"""Its least and its greatest corner (3,)."""


FARTHEST_M = 9e4
"""Of the meshes from their files' origin: a session holds places to a hundred kilometres."""


@dataclass(frozen=True)
class Reading:
    """How a person wants meshes read; what is None is for the files to say, or guessed.

    cameras: path of the calibrated cameras' file, as it is to stand in the session.
    """

    units: Units | None = None
    up: UpAxis | None = None
    cameras: str | None = None


@dataclass(frozen=True)
class SurfaceSetup:
    """How surfaces are read, the camera that looks at them, and what was guessed, in a sentence.

    height_m: of the first surface, upward.
    """

    surface: Surface
    camera: Camera
    guesses: tuple[str, ...]
    height_m: float


def choose_reading(
    sequence: MeshSequence, reading: Reading, rig: Rig | None = None
) -> SurfaceSetup:
    """How a new session reads these meshes. SurfaceError where none of them can be used.

    rig: the cameras, whose world is that of the meshes.
    """
    frame, mesh = first_mesh(sequence)
    units = reading.units or sequence.stated_units or (rig.units if rig else None)
    up = reading.up or sequence.stated_up or (rig.up if rig else None)
    guesses = _describe_guesses(mesh, units, up)
    units, up = units or _likely_units(mesh), up or guess_up(mesh)
    camera = Camera.from_field_of_view(WIDTH, HEIGHT, FIELD_OF_VIEW)
    unmoved = Placement(units, up, np.zeros(3))
    first = _box(unmoved, mesh)
    place = _place_origin(first, _boxes(sequence, unmoved, first, frame), camera)
    _require_near(place, units)
    surface = Surface(
        units=units,
        up=up,
        p_camera_surface=place,
        fps=FPS,
        cameras=reading.cameras,
    )
    return SurfaceSetup(surface, camera, guesses, height_m=float(first[1][1] - first[0][1]))


def _require_near(place: tuple[float, float, float], units: Units) -> None:
    """A camera and a body are metres away, not the Earth's radius."""
    if max(map(abs, place)) > FARTHEST_M:
        raise SurfaceError(
            f"The meshes lie {max(map(abs, place)) / 1000:,.0f} km from their origin, read in "
            f"{units}: move them to it, or name the right units with --units."
        )


def first_mesh(sequence: MeshSequence) -> tuple[int, SurfaceMesh]:
    """The first step that can be used, and its mesh as it is in the file."""
    problem = "There is no mesh."
    for frame in range(min(sequence.frame_count, MOST_UNUSABLE)):
        try:
            return frame, sequence.mesh(frame)
        except SurfaceError as error:
            problem = str(error) if frame == 0 else problem
    raise SurfaceError(problem)


def _likely_units(mesh: SurfaceMesh) -> Units:
    """The units of a person, else those by which the surface is nearest to a person's size."""
    longest = float(mesh.extent.max())

    def off(unit: Units) -> float:
        return abs(math.log(max(METRES[unit] * longest, 1e-12) / PERSON_M))

    guessed = guess_units(longest)
    return min(METRES, key=off) if guessed is None else guessed


def _describe_guesses(mesh: SurfaceMesh, units: Units | None, up: UpAxis | None) -> tuple[str, ...]:
    """What is guessed; nothing where all is known."""
    if units is not None and up is not None:
        return ()
    likely = units or _likely_units(mesh)
    size = METRES[likely] * float(mesh.extent.max())
    guessed = [
        *([f"read in {likely}, {size:.2f} m large"] if units is None else []),
        *([f"taken to have {guess_up(mesh)} up"] if up is None else []),
    ]
    unstated = {
        (True, True): "units and what is up",
        (True, False): "units",
        (False, True): "what is up",
    }[units is None, up is None]
    return (
        f"The meshes do not state their {unstated}: they are {' and '.join(guessed)}; "
        "change it under Fit if that is wrong.",
    )


def _box(placement: Placement, mesh: SurfaceMesh) -> Box:
    p = placement.points(mesh.vertices)
    return p.min(axis=0), p.max(axis=0)


def _boxes(sequence: MeshSequence, placement: Placement, first: Box, frame: int) -> Box:
    """Around several steps, from the first to the last; the few that cannot be used are missing."""
    low, high = first
    for step in np.linspace(frame, sequence.frame_count - 1, LOOKED_AT).round().astype(int)[1:]:
        try:
            lower, higher = _box(placement, sequence.mesh(int(step)))
        except SurfaceError:
            continue
        low, high = np.minimum(low, lower), np.maximum(high, higher)
    return low, high


def _place_origin(first: Box, all_of_them: Box, camera: Camera) -> tuple[float, float, float]:
    """Where the origin goes, so that the camera sees all; or the first well, where they go
    far.
    """
    near = _nearest_z(all_of_them, camera)
    box = all_of_them
    behind = float(first[0][2] - box[0][2])
    height_px = (first[1][1] - first[0][1]) * camera.fy / (near + behind)
    if height_px < LEAST_HEIGHT * camera.height:
        box, near = first, _nearest_z(first, camera)
    x, y = -(box[0] + box[1])[:2] / 2
    return round(float(x), 4), round(float(y), 4), round(float(near - box[0][2]), 4)


def _nearest_z(box: Box, camera: Camera) -> float:
    """How near its front may come."""
    width, height = (box[1] - box[0])[:2]
    return max(
        float(height) * camera.fy / (FILLED_HEIGHT * camera.height),
        float(width) * camera.fx / (FILLED_WIDTH * camera.width),
        NEAREST_M,
    )
