"""Parts added, taken away and renamed leave a body that is one tree."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import with_new_part, with_renamed_part, without_part
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.preset_names import PRESETS, RIGID
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError
from keypose.tracker.geometry.rotations import apply_transform

MAN = preset("adult_male")


@pytest.mark.parametrize("name", PRESETS)
def test_a_new_part_begins_where_its_parent_ends_and_turns_in_every_way(name: str) -> None:
    body = preset(name)
    for parent in body.parts:
        made = with_new_part(body, parent.name, "racket")
        part = made.parts[-1]
        assert (part.name, part.parent, part.tracked) == ("racket", parent.name, ("rx", "ry", "rz"))
        Ts = pose_transforms(Skeleton.of(made), Pose.rest(Skeleton.of(made), (0.0, 0.0, 3.0)))
        start, end = part.shape.span_y
        at = {made.parts[i].name: Ts[i] for i in range(len(Ts))}
        begins = apply_transform(at["racket"], np.array([[0.0, start, 0.0]]))
        ends = apply_transform(at[parent.name], np.array([[0.0, parent.shape.span_y[1], 0.0]]))
        np.testing.assert_allclose(begins, ends, atol=1e-12)
        assert abs(end - start) == pytest.approx(parent.shape.length_m)
        assert without_part(made, "racket") == body


def test_a_part_is_taken_away_with_all_that_hangs_on_it_and_its_pair() -> None:
    left = without_part(MAN, "left_thigh")
    gone = set(MAN.names) - set(left.names)
    assert gone == {"left_thigh", "left_shin", "left_foot"}
    assert not any(gone & set(pair) for pair in left.mirror_pairs)


def test_a_new_name_stands_wherever_the_body_names_the_part() -> None:
    renamed = with_renamed_part(MAN, "left_thigh", "upper_leg")
    assert renamed.parts[renamed.index("left_shin")].parent == "upper_leg"
    assert ("upper_leg", "right_thigh") in renamed.mirror_pairs
    assert with_renamed_part(renamed, "upper_leg", "left_thigh") == MAN


def test_names_are_unique_and_known() -> None:
    with pytest.raises(BodyError, match="already"):
        with_new_part(MAN, "head", "chest")
    with pytest.raises(BodyError, match="already"):
        with_renamed_part(MAN, "head", "chest")
    for act in (lambda: without_part(MAN, "tail"), lambda: with_new_part(MAN, "tail", "tip")):
        with pytest.raises(BodyError, match="no part 'tail'"):
            act()


def test_one_part_stays() -> None:
    for name in RIGID:
        with pytest.raises(BodyError, match="one part at least"):
            without_part(preset(name), name)
