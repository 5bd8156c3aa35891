"""What is made of a body once: shared while the body is the same, and never that of another one."""

from __future__ import annotations

import gc
import weakref

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.shapes import Cylinder
from keypose.tracker.body.skeleton import BODIES, Skeleton, once_per_body


def rod(length_m: float) -> Body:
    part = Part(
        name="rod", shape=Cylinder(radius_m=0.1, start_m=0.0, end_m=length_m), tracked=("tx",)
    )
    return Body(name="rod", parts=(part,))


def test_the_arrays_of_a_body_are_made_once() -> None:
    body = rod(1.0)
    assert Skeleton.of(body) is Skeleton.of(body)


def test_a_body_that_is_another_one_gets_its_own_however_alike() -> None:
    one, other = rod(1.0), rod(1.0)
    assert one == other
    assert Skeleton.of(one).body is one
    assert Skeleton.of(other).body is other


def test_what_was_made_of_bodies_long_gone_does_not_stay_in_memory() -> None:
    made: list[str] = []

    @once_per_body
    def named(body: Body) -> str:
        made.append(body.name)
        return body.name

    first = rod(1.0)
    gone = weakref.ref(first)
    assert [named(first), named(first)] == ["rod", "rod"]
    assert len(made) == 1
    del first
    for k in range(BODIES):
        named(rod(1.0 + k))
    gc.collect()
    assert gone() is None
