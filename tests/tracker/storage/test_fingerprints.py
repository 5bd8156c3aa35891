"""Results by their keys: what makes one outdated, what finds it again, what stays."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.body import Twist, preset
from keypose.tracker.body.shapes import Cylinder
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation
from keypose.tracker.keypoints.lifting import OFFSETS_S
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.session import IgnoreMask, PartKeyframe, Session, TrackSettings
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.session.references import KeypointFile
from keypose.tracker.storage import fingerprints
from keypose.tracker.storage.fingerprints import (
    LIFTED_FROM_S,
    segment_key,
    segment_keys,
    without_part_keyframes,
)
from keypose.tracker.storage.networks import add_own
from keypose.tracker.storage.results import (
    Results,
    collection,
    listed,
    observability,
    pose_at,
    residual,
    rotations,
    tidy_tracks,
)
from tests.app.results_cases import PARTS, both, passing, session, track
from tests.tracker import panned_cases
from tests.tracker import session_cases as cases
from tests.tracker.keypoints import tiny_networks as tiny

KEYPOINTS = "keypoints-0123456789ab.npz"
SQUARE = ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0))
Change = Callable[[Session], dict[str, Any]]


def mask(first: int, last: int, note: str = "", polygon: Any = SQUARE) -> IgnoreMask:
    return IgnoreMask(polygon=polygon, first_frame=first, last_frame=last, note=note)


def part(of: Session, name: str, **changes: Any) -> dict[str, Any]:
    old = of.subject.body.parts[of.subject.body.index(name)]
    return {"body": of.subject.body.with_part(old.model_copy(update=changes))}


def posed(of: Session, index: int, **changes: Any) -> dict[str, Any]:
    frames = list(of.subject.keyframes)
    frames[index] = frames[index].model_copy(update=changes)
    return {"keyframes": tuple(frames)}


def turned_over(of: Session) -> dict[str, Any]:
    """Every quaternion with the other sign, which is the same rotation."""
    rotations = of.subject.keyframes[1].rotations_wxyz.items()
    return posed(of, 1, rotations_wxyz={n: tuple(-c for c in q) for n, q in rotations})


def without_rest(of: Session) -> dict[str, Any]:
    """The keyframe at 0 is the rest pose; then its rotations may be left out."""
    return posed(of, 0, rotations_wxyz={})


def settings(**changes: Any) -> Change:
    return lambda of: {"settings": of.settings.model_copy(update=changes)}


def video(**changes: Any) -> Change:
    return lambda of: {"video": of.view.video.model_copy(update=changes)}


OUTDATES_ALL: dict[str, Change] = {
    "a longer part": lambda of: part(of, "left_arm", shape=Cylinder(end_m=0.5, radius_m=0.05)),
    "a joint elsewhere": lambda of: part(of, "left_arm", joint_m=(0.3, -0.2, 0.0)),
    "other motions tracked": lambda of: part(of, "left_arm", tracked=("rx",)),
    "a landmark elsewhere": lambda of: part(of, "left_hand", landmarks={"tip": (0.0, 0.1, 0.0)}),
    "another focal length": lambda of: {"camera": of.view.camera.model_copy(update={"fx": 61.0})},
    "a distorted lens": lambda of: {
        "camera": of.view.camera.model_copy(update={"distortion": (0.1, 0.0, 0.0, 0.0, 0.0)})
    },
    "the other method": settings(method="paper"),
    "more passes": settings(passes=7),
    "a static camera": settings(static_camera=True),
    "a mask over everything": lambda of: {"ignore_masks": (mask(0, 8),)},
    "interlaced frames left woven": video(deinterlace=False),
    "the middle keyframe moved": lambda of: posed(of, 1, root_m=(0.2, 0.0, 3.0)),
    "the middle keyframe turned": lambda of: posed(of, 1, rotations_wxyz={}),
}
OUTDATES_NONE: dict[str, Change] = {
    "the quality": settings(quality="preview"),
    "the body's name": lambda of: {"body": of.subject.body.model_copy(update={"name": "other"})},
    "where sizes come from": lambda of: {
        "body": of.subject.body.model_copy(update={"source": "a book"})
    },
    "a limit of posing": lambda of: part(of, "left_arm", limits_deg={"x": (-10.0, 90.0)}),
    "a limit of twist": lambda of: part(of, "left_arm", twist=Twist(range_deg=(-90.0, 90.0))),
    "the camera's origin": lambda of: {
        "camera": of.view.camera.model_copy(update={"origin": "guess"})
    },
    "another rate of recording": video(recorded_fps=240.0),
    "a keyframe's time": lambda of: posed(of, 1, time_s=0.2),
    "signs of quaternions": turned_over,
    "rotations at rest left out": without_rest,
    "keypoints, which are a person's": lambda of: {
        "keypoints": KeypointFile(file=KEYPOINTS, source="file"),
        "settings": of.settings.model_copy(update={"cues": ("brightness", "keypoints")}),
    },
    "a draft": lambda of: {"drafts": (of.subject.keyframes[1].model_copy(update={"frame": 2}),)},
    "old results": lambda of: {"results": None},
}


def test_the_motion_follows_the_content_of_a_network_of_ones_own_not_its_name(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def with_network(network: str) -> Session:
        named = {"cues": ("brightness", "keypoints"), "network": network}
        settings = person.settings.model_copy(update=named)
        return person.changed({"settings": settings})

    def key(network: str) -> str:
        return next(iter(segment_keys(of[network]).values()))

    frames = [k.model_copy(update={"rotations_wxyz": {}}) for k in session().subject.keyframes]
    bare = {"body": preset("adult_male"), "keyframes": tuple(frames)}
    person = session().changed(bare)
    of = {name: with_network(name) for name in ("mine", "other")}  # both stay open
    missing = key("mine")
    keys = []
    for name, content in (("mine", tiny.simcc()), ("mine", tiny.maps()), ("other", tiny.maps())):
        (tmp_path / "file").write_bytes(content)
        add_own(name, tmp_path / "file", hashlib.sha256(content).hexdigest())
        keys.append(key(name))
    assert keys[1] == keys[2]
    assert len({missing, *keys}) == 3


def test_the_motion_of_a_person_depends_on_the_keypoints_that_count() -> None:
    bare = session().changed({"body": preset("adult_male"), "keyframes": ()})
    frames = [k.model_copy(update={"rotations_wxyz": {}}) for k in session().subject.keyframes]
    bare = bare.changed({"keyframes": tuple(frames)})
    both_cues = bare.settings.model_copy(update={"cues": ("brightness", "keypoints")})
    detected = bare.changed({"settings": both_cues})
    from_box = KeypointFile(file=KEYPOINTS, source="full", network="0")
    imported = KeypointFile(file=KEYPOINTS, source="file.json")
    paper = detected.settings.model_copy(update={"method": "paper"})

    def keys(of: Session, **changes: Any) -> tuple[str, ...]:
        return tuple(segment_keys(of.changed(changes)).values())

    heavy = both_cues.model_copy(update={"network": "heavy"})
    assert keys(detected, settings=heavy) != keys(detected)
    assert keys(bare, settings=bare.settings.model_copy(update={"network": "heavy"})) == keys(bare)
    assert keys(bare, keypoints=imported) == keys(bare)
    assert keys(detected) != keys(bare)
    assert keys(detected, keypoints=imported) not in (keys(detected), keys(bare))
    assert keys(detected, keypoints=from_box) == keys(detected)  # found again from the keyframes
    every_cue = both_cues.model_copy(update={"cues": (*both_cues.cues, "silhouette")})
    assert keys(detected, settings=every_cue) != keys(detected)  # by the mask of the person
    lifted = both_cues.model_copy(update={"cues": (*both_cues.cues, "depth")})
    assert keys(detected, settings=lifted) != keys(detected)
    first, *others = detected.subject.keyframes
    of_draft = {"keyframes": (first.model_copy(update={"drafted": True}), *others)}
    assert keys(detected, **of_draft) == keys(detected)  # only their depth says how they came
    unposed = keys(detected, **of_draft, settings=lifted)
    assert [a == b for a, b in zip(unposed, keys(detected, settings=lifted), strict=True)] == [
        False,
        True,
    ]
    quick = detected.view.video.model_copy(update={"recorded_fps": 240.0})
    assert keys(detected, settings=lifted, video=quick) != keys(detected, settings=lifted)
    alone = both_cues.model_copy(update={"cues": ("brightness", "depth")})
    brightness = both_cues.model_copy(update={"cues": ("brightness",)})
    assert keys(detected, settings=alone) == keys(detected, settings=brightness)
    thing = {"body": session().subject.body, "keyframes": session().subject.keyframes}
    assert keys(detected, **thing, settings=every_cue) == keys(detected, **thing)
    still, with_all = (c.model_copy(update={"static_camera": True}) for c in (both_cues, every_cue))
    assert keys(detected, settings=with_all) != keys(detected, settings=still)
    no_cues = paper.model_copy(update={"cues": None})
    assert keys(detected, settings=paper) == keys(detected, settings=no_cues)


def test_a_drafts_keypoints_count_in_the_segments_of_their_frames(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With the network that found them, and with masks of the person where these are wanted."""
    monkeypatch.setattr(fingerprints, "KEYPOINT_RUN", 4)
    frames = [k.model_copy(update={"rotations_wxyz": {}}) for k in session().subject.keyframes]
    bare = session().changed({"body": preset("adult_male"), "keyframes": tuple(frames)})
    both = bare.settings.model_copy(
        update={"cues": ("brightness", "keypoints"), "network": "thunder", "static_camera": True}
    )
    person = bare.changed({"settings": both})
    drafted = KeypointFile(
        file=KEYPOINTS, source="BlazePose", network="any runtime",
        model=find_model("thunder").sha256, runs=("00000000", "11111111"),
    )  # fmt: skip
    assert person.spans == ((0, 4), (4, 8))

    def keys(of: Session, **changes: Any) -> list[str]:
        return list(segment_keys(of.changed(changes)).values())

    plain, of_draft = keys(person), keys(person, keypoints=drafted)
    assert not set(plain) & set(of_draft)
    again = drafted.model_copy(
        update={"file": KEYPOINTS.replace("0", "1"), "runs": ("00000000", "22222222")}
    )
    later = drafted.model_copy(update={"runs": (*drafted.runs, "33333333")})
    assert keys(person, keypoints=again)[0] != of_draft[0], "its end is in the second run"
    assert keys(person, keypoints=later)[0] == of_draft[0]
    assert keys(person, keypoints=later)[1] != of_draft[1]
    lifted = both.model_copy(update={"cues": (*both.cues, "depth")})  # which looks beyond it
    apart = person.subject.keyframes[-1].frame - person.subject.keyframes[0].frame
    slow, quick = (
        [k.model_copy(update={"time_s": k.frame * step}) for k in person.subject.keyframes]
        for step in (2 * LIFTED_FROM_S, LIFTED_FROM_S / (apart + 8))
    )
    for keyframes, changed in ((slow, [False, True]), (quick, [True, True])):
        of = person.changed({"settings": lifted, "keyframes": tuple(keyframes)})
        ends = [keys(of, keypoints=k) for k in (drafted, later)]
        assert [ends[0][n] != ends[1][n] for n in (0, 1)] == changed
    assert OFFSETS_S[-1] < LIFTED_FROM_S
    assert keys(person, keypoints=drafted.model_copy(update={"model": "", "runs": ()})) == plain
    for changes in ({"network": "heavy"}, {"cues": ("brightness",)}):
        settings = both.model_copy(update=changes)
        assert keys(person, keypoints=drafted, settings=settings) == keys(person, settings=settings)
    masks = {"static_camera": False, "cues": ("brightness", "keypoints", "silhouette")}
    settings = both.model_copy(update=masks)
    assert keys(person, keypoints=drafted, settings=settings) == keys(person, settings=settings)
    outlined = drafted.model_copy(update={"masks": True})
    assert keys(person, keypoints=outlined, settings=settings) != keys(person, settings=settings)
    alone = settings.model_copy(update={"cues": ("brightness", "silhouette")})
    assert keys(person, keypoints=outlined, settings=alone) != keys(person, settings=alone)
    assert keys(person, keypoints=drafted, settings=alone) == keys(person, settings=alone)


def test_a_limb_keyed_alone_outdates_its_own_segment_and_without_it_all_is_as_before() -> None:
    bare, pose = session(), session().subject.keyframes[1].model_dump()
    before = list(segment_keys(bare).values())

    def keys(**changes: Any) -> list[str]:
        part = PartKeyframe(**{**pose, "frame": 2, "time_s": 0.08, "parts": ("left_hand",)})
        given = bare.changed({"part_keyframes": (part.model_copy(update=changes),)})
        assert segment_keys(without_part_keyframes(given)) == segment_keys(bare)
        return list(segment_keys(given).values())

    keyed = keys()
    assert keyed[0] != before[0]
    assert keyed[1] == before[1]
    assert keys(time_s=0.09) == keyed
    for other in ({"frame": 3}, {"parts": ("left_arm", "left_hand")}, {"root_m": (0.1, 0, 3.0)}):
        assert keys(**other)[0] not in (keyed[0], before[0])
    assert keys(frame=6)[0] == before[0]


def test_a_corrected_keypoint_outdates_the_segment_it_lies_in_where_keypoints_count() -> None:
    rest = [k.model_copy(update={"rotations_wxyz": {}}) for k in session().subject.keyframes]
    bare = {"body": preset("adult_male"), "keyframes": tuple(rest)}
    both_cues = TrackSettings(cues=("brightness", "keypoints"))

    def keys(tracked_by: TrackSettings, *given: KeypointCorrection) -> list[str]:
        changes = {**bare, "settings": tracked_by, "keypoint_corrections": given}
        return list(segment_keys(session().changed(changes)).values())

    wrist = KeypointCorrection(frame=6, joint="left_wrist", uv=(9.0, 9.0))
    none, late = keys(both_cues), keys(both_cues, wrist)
    assert late[0] == none[0]
    moved = wrist.model_copy(update={"uv": (9.5, 9.0)})
    hidden = wrist.model_copy(update={"uv": None})
    assert len({none[1], late[1], keys(both_cues, moved)[1], keys(both_cues, hidden)[1]}) == 4
    brightness = TrackSettings(cues=("brightness",))
    assert keys(brightness, wrist) == keys(brightness)


@pytest.mark.parametrize("change", OUTDATES_ALL.values(), ids=OUTDATES_ALL)
def test_what_changes_the_motion_outdates_both_segments_and_undo_finds_them(change: Change) -> None:
    before = session()
    results = both(before)
    after = before.changed(change(before))
    assert results.fitting(after) == {}
    assert set(results.states(after).values()) == {"outdated"}
    assert results.fitting(before) == {(0, 4): track_at(results, 0), (4, 8): track_at(results, 4)}


@pytest.mark.parametrize("change", OUTDATES_NONE.values(), ids=OUTDATES_NONE)
def test_what_changes_no_motion_outdates_nothing(change: Change) -> None:
    before = session()
    after = before.changed(change(before))
    assert segment_keys(after) == segment_keys(before)


def track_at(results: Results, first: int) -> Any:
    return next(t for t in results.by_key.values() if t.first == first)


def test_a_keyframe_outdates_the_segments_beside_it_and_no_other() -> None:
    before = session()
    after = before.changed(posed(before, 2, root_m=(0.0, 0.0, 3.1)))
    assert list(both(before).fitting(after)) == [(0, 4)]
    assert both(before).states(after) == {(0, 4): "good", (4, 8): "outdated"}


def test_a_mask_outdates_the_segments_it_lies_in_by_what_it_does_there() -> None:
    def keys(*masks: IgnoreMask) -> list[str]:
        return list(segment_keys(session(ignore_masks=masks)).values())

    none, late, longer = keys(), keys(mask(6, 7)), keys(mask(6, 30))
    assert late[0] == none[0]
    assert len({none[1], late[1], longer[1]}) == 3
    assert longer == keys(mask(6, 8))  # beyond the last frame it does nothing
    assert keys(mask(6, 7, note="a chair")) == late
    assert keys(mask(6, 7, polygon=SQUARE[::-1])) != late
    one, other = mask(0, 3), mask(2, 5)
    assert keys(one, other) == keys(other, one)


def test_adding_and_taking_away_a_keyframe_finds_the_old_segment_again() -> None:
    before = session()
    results = both(before)
    fewer = before.changed({"keyframes": before.subject.keyframes[::2]})
    assert results.fitting(fewer) == {}
    assert results.states(fewer) == {(0, 8): "outdated"}
    assert len(results.fitting(before)) == 2


def test_what_was_never_tracked_is_not_outdated() -> None:
    of = session()
    assert set(Results().states(of).values()) == {"none"}
    assert Results().with_result(track(of, 0, 4)).states(of) == {(0, 4): "good", (4, 8): "none"}


def test_a_preview_never_replaces_a_better_result_of_the_same_key() -> None:
    of = session()
    preview, full = track(of, 0, 4, "preview"), track(of, 0, 4)
    results = Results().with_result(preview).with_result(full)
    assert results.fitting(of) == {(0, 4): full}
    for worse in (preview, passing(of, 0, 4, 0.2)):
        assert results.with_result(worse) is results
    again = track(of, 0, 4)
    assert results.with_result(again).fitting(of) == {(0, 4): again}


def test_a_trajectory_on_the_way_stands_until_something_is_finished() -> None:
    of = session()
    first, second = passing(of, 0, 4, 0.1), passing(of, 0, 4, 0.2)
    results = Results().with_result(first).with_result(second)
    assert results.fitting(of) == {(0, 4): second}
    assert not second.finished
    assert second.verdict is None
    assert results.states(of)[0, 4] == "outdated"
    preview = track(of, 0, 4, "preview")
    assert results.with_result(preview).with_result(second).fitting(of) == {(0, 4): preview}


def test_wanted_is_what_has_no_finished_result_of_the_quality_asked_for() -> None:
    of = session(settings=TrackSettings(quality="full"))
    results = Results().with_result(track(of, 0, 4, "preview")).with_result(track(of, 4, 8))
    assert results.wanted(of) == [(0, 4, segment_key(of, 0, 4))]
    assert results.wanted(of, "preview") == []
    unfinished = Results().with_result(passing(of, 4, 8, 0.1))
    assert [w[:2] for w in unfinished.wanted(of, "preview")] == [(0, 4), (4, 8)]


def test_of_too_many_results_the_oldest_go_and_those_in_use_stay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(collection, "MOST_SEGMENTS", 3)
    results, of = Results(), session()
    variants = [of.changed(posed(of, 0, root_m=(0.0, 0.0, 3 + k))) for k in range(6)]
    kept = segment_key(variants[0], 0, 4)
    for variant in variants:
        results = results.with_result(track(variant, 0, 4), keep=(kept,))
    assert list(results.by_key) == [segment_key(v, 0, 4) for v in (variants[0], *variants[4:])]


def test_long_segments_fill_the_room_sooner(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(collection, "MOST_FRAMES", 9)
    assert len(both(session())) == 1


def test_the_tracked_pose_is_known_within_what_fits() -> None:
    of = session()
    fitting = Results().with_result(track(of, 4, 8)).fitting(of)
    pose = pose_at(fitting, 6)
    assert pose is not None
    np.testing.assert_array_equal(
        pose.p_camera_root, cases.segment(4, 8).trajectory.pose(6).p_camera_root
    )
    assert pose_at(fitting, 3) is None
    assert pose_at(fitting, 9) is None


def test_what_the_picture_gives_is_known_by_frame_and_part() -> None:
    of = session()
    seen = observability(both(of).fitting(of), 12, PARTS)
    assert seen.shape == (12, PARTS)
    np.testing.assert_array_equal(seen[:9, 0], 0.5)
    assert np.isnan(seen[9:]).all()
    assert np.isnan(seen[:, 1]).all()  # a part that is not tracked
    assert listed(seen[7:12, 0]) == [[0, 0.5, 0.5]]
    assert listed(residual(both(of).fitting(of), 9, PARTS)[:1, 0]) == [[0, 2.5]]


def test_of_a_series_what_is_known_is_listed_behind_the_frame_it_begins_at() -> None:
    column = np.array([np.nan, 1.23456, 2.0, np.nan, np.nan, 5.0])
    assert listed(column, 2) == [[1, 1.23, 2.0], [5, 5.0]]
    assert listed(np.full(3, np.nan)) == listed(np.zeros(0)) == []


def test_a_trajectory_on_the_way_measures_nothing() -> None:
    of = session()
    fitting = Results().with_result(passing(of, 0, 4, 0.1)).fitting(of)
    assert np.isnan(observability(fitting, 9, PARTS)).all()
    assert np.isfinite(rotations(fitting, 9, 0)[:5]).all()


def test_rotations_are_known_by_frame_where_something_fits() -> None:
    of = session()
    table = rotations(both(of).fitting(of), 12, 2)
    assert np.isnan(table[9:]).all()
    np.testing.assert_allclose(table[:9] @ np.swapaxes(table[:9], 1, 2), [np.eye(3)] * 9, atol=1e-9)


def test_old_tracks_files_go_when_no_session_speaks_of_them_and_young_ones_stay(
    tmp_path: Path,
) -> None:
    names = [f"tracks-{letter * 12}.npz" for letter in "abcd"]
    for name in names:
        (tmp_path / name).write_bytes(b"")
        os.utime(tmp_path / name, (1.0, 1.0))
    os.utime(tmp_path / names[3])
    (tmp_path / "session.json").write_text(f'"{names[0]}"')
    (tmp_path / "session.json.previous").write_text(f'"{names[1]}"')
    (tmp_path / "tracks-mine.npz").write_bytes(b"")
    tidy_tracks(tmp_path)
    left = {file.name for file in tmp_path.glob("*.npz")}
    assert left == {names[0], names[1], names[3], "tracks-mine.npz"}


@pytest.mark.parametrize("stands", [True, False], ids=["still", "panned"])
def test_keys_of_steadied_film_are_those_of_any_processor(stands: bool) -> None:
    session = panned_cases.panned()
    assert session.view.camera_motion is not None
    path = session.view.camera_motion.path
    turns = np.zeros((len(path), 3)) if stands else log_rotation(path.Ts_camera_world[:, :3, :3])

    def keys(seed: int) -> dict[tuple[int, int], str]:
        rounding = np.random.default_rng(seed).normal(0, 1e-16, turns.shape)
        along = CameraPath.of(exp_rotation(turns + rounding), 0 * turns, path.zoom)
        return segment_keys(session.changed({"camera_motion": CameraMotion.of("turns", along)}))

    assert keys(0) == keys(1)
