"""How a new session looks at surfaces: all of them in the picture, else the first one well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.new_session import (
    FILLED_HEIGHT,
    FILLED_WIDTH,
    FPS,
    HEIGHT,
    LEAST_HEIGHT,
    LOOKED_AT,
    MOST_UNUSABLE,
    NEAREST_M,
    WIDTH,
    Reading,
    SurfaceSetup,
    choose_reading,
    first_mesh,
)
from keypose.tracker.surface.placing import Placement
from tests.tracker.surface.mesh_files import BOX

PERSON = (0.5, 1.7, 0.4)
AS_IT_IS = Reading("m", "-y")
"""The files' axes are the camera's."""


@dataclass(frozen=True)
class Meshes:
    """A sequence in memory; None is a step that cannot be used."""

    steps: Sequence[SurfaceMesh | None]
    stated_units: Any = None
    stated_up: Any = None

    @property
    def frame_count(self) -> int:
        return len(self.steps)

    def mesh(self, frame: int) -> SurfaceMesh:
        mesh = self.steps[frame]
        if mesh is None:
            raise SurfaceError(f"Step {frame} cannot be used.")
        return mesh


def box(size: Sequence[float] = PERSON, at: Sequence[float] = (0, 0, 0)) -> SurfaceMesh:
    """A box about a place."""
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / 2
    return SurfaceMesh(corners * np.asarray(size, float) + np.asarray(at, float), BOX)


def opened(*steps: SurfaceMesh | None, reading: Reading = AS_IT_IS, **message: Any) -> SurfaceSetup:
    return choose_reading(Meshes(steps, **message), reading)  # type: ignore[arg-type]


def seen(how: SurfaceSetup, mesh: SurfaceMesh) -> tuple[Array, Array]:
    """(2,) least and greatest pixel of a mesh in the picture of the session's camera."""
    surface = how.surface
    placed = Placement(surface.units, surface.up, np.array(surface.p_camera_surface))
    uv = how.camera.project(placed.points(mesh.vertices))
    return uv.min(axis=0), uv.max(axis=0)


def share_of_height(how: SurfaceSetup, mesh: SurfaceMesh) -> float:
    low, high = seen(how, mesh)
    return float((high - low)[1]) / HEIGHT


def is_whole(how: SurfaceSetup, mesh: SurfaceMesh) -> bool:
    low, high = seen(how, mesh)
    return bool((low > -0.5).all() and (high < (WIDTH - 0.5, HEIGHT - 0.5)).all())


def test_a_surface_that_stays_fills_its_share_of_the_height_in_the_middle_of_the_picture() -> None:
    mesh = box(at=(3.0, -2.0, 5.0))
    how = opened(mesh, mesh)
    low, high = seen(how, mesh)
    assert share_of_height(how, mesh) == pytest.approx(FILLED_HEIGHT, abs=1e-3)
    middle = ((WIDTH - 1) / 2, (HEIGHT - 1) / 2)
    np.testing.assert_allclose((low + high) / 2, middle, atol=0.5)
    assert how.height_m == pytest.approx(1.7)


def test_a_wide_surface_fills_its_share_of_the_width() -> None:
    mesh = box((4.0, 1.0, 0.4))
    low, high = seen(opened(mesh), mesh)
    assert (high - low)[0] == pytest.approx(FILLED_WIDTH * WIDTH, abs=1.0)


def test_a_small_surface_is_no_nearer_than_a_camera_can_be() -> None:
    mesh = box((0.01, 0.01, 0.02))
    z = opened(mesh).surface.p_camera_surface[2]
    assert z - 0.01 == pytest.approx(NEAREST_M, abs=1e-4)


NEAR_M = opened(box()).surface.p_camera_surface[2] - 0.2
"""Of a person who stays: how far the front is from the camera."""


@pytest.mark.parametrize("from_m", [0.5 * NEAR_M, 0.97 * NEAR_M])
def test_surfaces_that_come_nearer_are_all_seen_where_the_first_is_not_too_small(
    from_m: float,
) -> None:
    first, last = box(at=(0, 0, from_m + 2.0)), box(at=(0, 0, 2.0))
    how = opened(first, last)
    assert is_whole(how, first)
    assert share_of_height(how, last) == pytest.approx(FILLED_HEIGHT, abs=1e-3)
    assert share_of_height(how, first) > LEAST_HEIGHT


@pytest.mark.parametrize("from_m", [1.03 * NEAR_M, 3 * NEAR_M])
def test_surfaces_that_come_from_too_far_are_seen_well_where_they_begin(from_m: float) -> None:
    first, last = box(at=(0, 0, from_m + 2.0)), box(at=(0, 0, 2.0))
    how = opened(first, last)
    assert share_of_height(how, first) == pytest.approx(FILLED_HEIGHT, abs=1e-3)


def test_both_how_far_back_the_first_stands_and_how_far_they_move_aside_count() -> None:
    """Neither the way to the side nor the way from behind makes it too small by itself."""
    aside = box(at=(2.6, 0, 0))
    assert share_of_height(opened(box(), aside), box()) > LEAST_HEIGHT
    behind = box(at=(0, 0, 4.9))
    assert share_of_height(opened(behind, box()), behind) > LEAST_HEIGHT
    how = opened(behind, aside)
    assert share_of_height(how, behind) == pytest.approx(FILLED_HEIGHT, abs=1e-3)
    assert not is_whole(how, aside)


def test_where_the_files_origin_is_does_not_change_what_is_seen() -> None:
    steps = [((0, 0, 3.0), (2.6, 0, 0)), ((0, 0, 2.0), (0, 0, 0)), ((0, 0, 0), (2.6, 0, 0))]
    for first, last in steps:
        shares = []
        for origin in ((0, 0, 0), (7.0, -3.0, 40.0), (0, 1.0, -40.0)):
            meshes = [box(at=np.add(place, origin)) for place in (first, last)]
            shares.append(share_of_height(opened(*meshes), meshes[0]))
        assert shares == pytest.approx([shares[0]] * 3, abs=1e-3)


def test_a_step_aside_between_the_first_and_the_last_is_seen_whole() -> None:
    for wanderer in (2, 4, 6, 8):
        steps = [box(at=(1.5 if i == wanderer else 0.0, 0, 0)) for i in range(9)]
        assert is_whole(opened(*steps), steps[wanderer])
    assert LOOKED_AT == 5  # of nine steps every other one


def test_steps_that_cannot_be_used_are_passed_over() -> None:
    steps = [None, box(), None, box(at=(1.5, 0, 0))]
    how = opened(*steps)
    assert is_whole(how, steps[1])
    assert is_whole(how, steps[3])


def test_the_first_mesh_is_looked_for_among_the_first_steps_and_the_first_fault_is_reported() -> (
    None
):
    none: list[SurfaceMesh | None] = [None] * (MOST_UNUSABLE - 1)
    frame, _ = first_mesh(Meshes([*none, box()]))  # type: ignore[arg-type]
    assert frame == MOST_UNUSABLE - 1
    with pytest.raises(SurfaceError, match=r"^Step 0 cannot be used"):
        first_mesh(Meshes([*none, None, box()]))  # type: ignore[arg-type]
    with pytest.raises(SurfaceError, match="There is no mesh"):
        first_mesh(Meshes([]))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("reading", "reported", "unreported"),
    [
        (Reading(), ("units", "read in m, 1.70 m large", "+y up"), ()),
        (Reading(up="-y"), ("units", "read in m, 1.70 m large"), ("up",)),
        (Reading("m"), ("+y up",), ("units", "1.70 m")),
    ],
)
def test_what_is_guessed_is_reported_and_nothing_else(
    reading: Reading, reported: tuple[str, ...], unreported: tuple[str, ...]
) -> None:
    (words,) = opened(box(), reading=reading).guesses
    assert [piece for piece in reported if piece not in words] == []
    assert [piece for piece in unreported if piece in words] == []


def test_what_a_person_or_the_files_say_is_not_guessed_and_a_person_comes_first() -> None:
    assert opened(box()).guesses == ()
    stated = opened(box(), reading=Reading(), stated_units="cm", stated_up="-z")
    assert (stated.surface.units, stated.surface.up, stated.surface.fps) == ("cm", "-z", FPS)
    assert stated.guesses == ()
    message = opened(box(), stated_units="cm", stated_up="-z")
    assert (message.surface.units, message.surface.up, message.surface.fps) == ("m", "-y", FPS)


def test_the_size_is_reported_in_metres_whatever_the_units() -> None:
    (words,) = opened(box((50, 170, 40)), reading=Reading(up="-y")).guesses
    assert "read in cm, 1.70 m large" in words


def test_where_neither_a_person_nor_the_files_say_it_the_cameras_do() -> None:
    rig: Any = SimpleNamespace(units="cm", up="-z")
    how = choose_reading(Meshes([box()]), Reading(), rig)  # type: ignore[arg-type]
    assert (how.surface.units, how.surface.up, how.guesses) == ("cm", "-z", ())
    stated = Meshes([box()], stated_units="mm", stated_up="+x")
    how = choose_reading(stated, Reading(), rig)  # type: ignore[arg-type]
    assert (how.surface.units, how.surface.up) == ("mm", "+x")


@pytest.mark.parametrize(
    ("longest", "units"), [(1.7, "m"), (12.0, "dm"), (3.0, "m"), (3.3, "ft"), (25_000.0, "mm")]
)
def test_units_by_which_no_surface_is_a_person_are_those_that_come_nearest(
    longest: float, units: str
) -> None:
    mesh = box((0.2 * longest, longest, 0.2 * longest))
    assert opened(mesh, reading=Reading(up="-y")).surface.units == units


def test_meshes_as_far_off_as_no_session_can_hold_are_refused() -> None:
    assert opened(box(at=(-8.9e4, 0, 0))).surface.p_camera_surface[0] == pytest.approx(8.9e4)
    with pytest.raises(SurfaceError, match=r"lie 92 km from their origin, read in m: .* --units"):
        opened(box(at=(9.2e4, 0, 0)))
