"""Parts that stand still for a whole film are followed though the empty scene shows themselves."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from tests.rendering import scenes
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings
from tests.tracker.tracking_cases import Case, tracked

MOVED = ("upper_arm", "forearm", "hand", "head")
FIRST = 10
LAST = 25


@pytest.fixture(scope="module")
def standing() -> Case:
    """Someone whose arms and head move, all else for the whole film in one place."""
    made = scenes.scene("speech", size=(480, 270))
    Rs, ps = (a[::3][:41].copy() for a in made.truth.writable())
    still = [i for i, name in enumerate(made.skeleton.body.names) if not name.endswith(MOVED)]
    Rs[:, still], ps[:] = Rs[0, still], ps[0]
    truth = Trajectory(0, Rs, ps)
    pictures = render(made.skeleton, truth, made.camera, RenderSettings())
    return Case(made.skeleton, made.camera, truth, pictures)


@pytest.mark.parametrize("static", [False, True])
def test_feet_that_stand_for_the_whole_film_stay_where_they_are(
    standing: Case, static: bool
) -> None:
    (segment,) = tracked(standing.tracker(FIRST, LAST, static_camera=static))
    found = segment.trajectory.transforms(standing.skeleton)
    true = standing.truth.transforms(standing.skeleton)[FIRST : LAST + 1]
    feet = [standing.skeleton.body.index(f"{side}_foot") for side in ("left", "right")]
    away = np.linalg.norm((found - true)[:, feet, :3, 3], axis=-1)
    assert away.max() < 0.006
