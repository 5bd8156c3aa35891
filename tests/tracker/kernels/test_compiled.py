"""How loops are compiled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba.core.caching import NullCache

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.kernels import compiled
from keypose.tracker.solver.posed import BodyPoints, Posed
from keypose.tracker.solver.robust import SQUARED
from keypose.tracker.solver.smoothness import Smoothness


@compiled
def _chosen(x: float, way: int, is_negative: bool) -> float:
    scaled = 2 * x if way == 1 else 3 * x
    return -scaled if is_negative else scaled


@compiled
def _both(x: float) -> float:
    return 10 * _chosen(x, 1, False) + _chosen(x, 2, is_negative=True)


def test_a_loop_is_compiled_once_whatever_constants_others_call_it_with(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    loop: Any = _chosen
    for kept in (_both, _chosen):
        monkeypatch.setattr(kept, "_cache", NullCache())
    assert _both(1.0) == 17.0
    assert len(loop.overloads) == 1


@pytest.mark.parametrize("order", ["C", "F"])
def test_loops_have_their_arrays_row_by_row_however_values_lie_in_memory(order: Any) -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    count, parts, dofs = 4, skeleton.part_count, skeleton.dof_count
    motion = Trajectory(0, np.tile(np.eye(3), (count, parts, 1, 1)), np.ones((count, 3)))
    posed = Posed(skeleton, motion.Rs_parent_part, motion.ps_camera_root)
    values = np.asarray(np.random.default_rng(0).normal(size=(count, 5, 2)), order=order)
    given = [posed.each(values, 2)]
    assert np.array_equal(given[0], values)
    for name in ("adult_male", "dog"):
        body = Skeleton.of(preset(name))
        ends = np.arange(3)
        given.append(BodyPoints.single(body, ends, np.zeros((3, 3))).places.moves)
    wanted = np.asarray(np.ones((count - 2, dofs)), order=order)
    given += Smoothness(skeleton, wanted, wanted, SQUARED)._wanted[:2]
    assert all(array.flags.c_contiguous for array in given)
