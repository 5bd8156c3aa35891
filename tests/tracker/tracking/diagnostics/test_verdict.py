"""The verdict for evidence made up to be clear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, Trajectory, interpolate
from keypose.tracker.session.verdict import GOOD, Verdict
from keypose.tracker.tracking.cues.joint_evidence import JointEvidence
from keypose.tracker.tracking.cues.silhouette import SilhouetteMismatch
from keypose.tracker.tracking.cycle import Outcome
from keypose.tracker.tracking.diagnostics.judge import judge
from keypose.tracker.tracking.diagnostics.observability import Observation, unobserved
from keypose.tracker.tracking.result import Diagnostics
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment
from keypose.tracker.video.pyramid import Clip, prepare
from tests.tracker.tracking_cases import scene_of

FIRST = 100
LAST = 120
N = LAST - FIRST
SKELETON = Skeleton.of(preset("adult_male"))
START = Pose.rest(SKELETON, (0.0, 0.0, 6.0))
END = Pose.rest(SKELETON, (0.2, 0.0, 6.0))
SEGMENT = Segment(FIRST, LAST, START, END, Clip(FIRST, ()))
SCENE: Scene = scene_of(SKELETON, poses=[START])
MARKS = len(SCENE.marks[1])
PATH: Trajectory = interpolate(START, END, FIRST, LAST)
FAR = 1000.0
Floats = NDArray[np.float64]


def outcome(
    apart: NDArray[np.float64] | None = None,
    drift: NDArray[np.float64] | None = None,
    diverged: bool = False,
    what: str = "pass",
    followed: bool = True,
) -> Outcome:
    still = np.zeros((N + 1, MARKS))
    return Outcome(
        (Pass(what, PATH, 3.0),), 0, still if apart is None else apart,
        still[1:] if drift is None else drift, followed, diverged, 0.0,
    )  # fmt: skip


def clear() -> Observation:
    """Everything is seen well."""
    parts = SKELETON.part_count
    observability = np.where(np.isin(np.arange(parts), SKELETON.dof_part), 0.9, np.nan) * np.ones(
        (N, 1)
    )
    residual = np.full((N, parts), 2.0)
    found = Diagnostics(np.full(N, 23), np.ones((N, 23)), observability, residual)
    return Observation(found, np.full((N, parts), 100))


def seen_as(observability: np.ndarray) -> Observation:
    """As clear, but for how much the picture tells."""
    seen = clear()
    return replace(seen, diagnostics=replace(seen.diagnostics, observability=observability))


def hidden(part: str, first: int, last: int) -> Observation:
    """A part is not seen from the pair `first` to the pair `last`, counted from 0."""
    observability = clear().diagnostics.observability.copy()
    observability[first : last + 1, SKELETON.body.index(part)] = 0.01
    return seen_as(observability)


def verdict(found: Outcome, seen: Observation | None = None) -> Verdict:
    return judge(SCENE, SEGMENT, found, seen or clear())


def test_where_all_evidence_agrees_it_is_good() -> None:
    assert verdict(outcome()) == GOOD


def test_without_having_looked_nothing_is_called_unseen() -> None:
    assert verdict(outcome(), unobserved(SCENE, SEGMENT.clip, PATH)).kind == "good"


def test_a_diverged_segment_asks_for_a_keyframe_in_its_middle() -> None:
    found = verdict(outcome(diverged=True, what="interpolation"))
    assert found == Verdict.not_followed(110)
    assert (found.kind, found.frames, found.go) == ("lost", (110, 110), 110)


def test_where_both_evidences_are_strong_a_keyframe_is_asked_for_where_they_are_strongest() -> None:
    apart, drift = np.zeros((N + 1, MARKS)), np.zeros((N, MARKS))
    apart[5:9], drift[5:9] = FAR, FAR
    found = verdict(outcome(apart, drift))
    assert found.go is not None
    assert FIRST + 4 <= found.go <= FIRST + 10
    assert found == Verdict.not_followed(found.go)


def test_a_keyframe_off_the_person_is_said_of_the_whole_body_unless_pictures_agree_with_it() -> (
    None
):
    astray = drifting("left_forearm")
    off = replace(outcome(drift=astray), off_person=FIRST)
    assert verdict(off) == Verdict.off_person(FIRST)
    assert verdict(off).part is None
    assert verdict(replace(outcome(), off_person=FIRST)) == GOOD


@pytest.mark.parametrize("strong", ["apart", "drift"])
def test_one_evidence_alone_names_the_part_and_the_frames_to_look_at(strong: str) -> None:
    joint = int(np.flatnonzero(SCENE.marks[1] == SKELETON.body.index("left_forearm"))[0])
    apart, drift = np.zeros((N + 1, MARKS)), np.zeros((N, MARKS))
    (apart if strong == "apart" else drift)[8:12, joint] = FAR
    found = verdict(outcome(apart, drift))
    assert (found.kind, found.cause, found.part) == ("check", "uncertain", "left_forearm")
    assert found.frames is not None
    assert FIRST + 6 <= found.frames[0] <= found.frames[1] <= FIRST + 13
    assert found.go == (found.frames[0] + found.frames[1] + 1) // 2


def drifting(part: str, first: int = 0, last: int = N) -> NDArray[np.float64]:
    """Drift of one mark of a part alone, strong enough for a word."""
    joint = int(np.flatnonzero(SCENE.marks[1] == SKELETON.body.index(part))[-1])
    drift = np.zeros((N, MARKS))
    drift[first:last, joint] = FAR
    return drift


@pytest.mark.parametrize(
    ("marked", "named"),
    [
        ("left_forearm", "left_forearm"),
        ("left_hand", "left_forearm"),
        ("right_foot", "right_shin"),
        ("neck", "chest"),
        ("head", "head"),
        ("waist", "waist"),
    ],
)
def test_a_part_that_is_not_tracked_is_reported_by_the_one_that_carries_it(
    marked: str, named: str
) -> None:
    found = verdict(outcome(drift=drifting(marked)))
    assert found == Verdict.check("uncertain", (FIRST + 1, LAST - 1), named)


def test_an_uncertain_part_that_was_hidden_meanwhile_is_reported_as_not_seen() -> None:
    drift = drifting("right_hand", 6, 8)
    where, part = (FIRST + 7, FIRST + 8), "right_forearm"
    uncertain = Verdict.check("uncertain", where, part)
    not_seen = Verdict.check("not_seen", where, part)
    assert verdict(outcome(drift=drift)) == uncertain
    assert verdict(outcome(drift=drift), hidden(part, 6, 7)) == not_seen
    covered = clear()
    covered.shown[6:8, SKELETON.body.index("right_forearm")] = 0
    assert verdict(outcome(drift=drift), covered) == not_seen
    assert verdict(outcome(drift=drift), hidden(part, 0, 1)) == uncertain


def test_without_having_looked_an_uncertain_part_is_not_called_unseen() -> None:
    blind = unobserved(SCENE, SEGMENT.clip, PATH)
    assert verdict(outcome(drift=drifting("left_shin")), blind).cause == "uncertain"


def test_at_the_keyframes_themselves_the_chains_may_differ() -> None:
    apart = np.zeros((N + 1, MARKS))
    apart[[0, N]] = FAR
    assert verdict(outcome(apart)).kind == "good"


def test_small_evidence_does_not_matter() -> None:
    assert verdict(outcome(np.full((N + 1, MARKS), 0.02), np.full((N, MARKS), 1e-4))).kind == "good"


def test_a_part_that_goes_unseen_is_named_with_its_frames() -> None:
    found = verdict(outcome(), hidden("right_upper_arm", 4, 11))
    assert found == Verdict.check("not_seen", (FIRST + 5, FIRST + 12), "right_upper_arm")


def test_the_part_unseen_for_longest_is_the_one_that_is_named() -> None:
    both = hidden("head", 2, 5).diagnostics.observability
    longer = hidden("left_shin", 1, 15).diagnostics.observability
    assert verdict(outcome(), seen_as(np.fmin(longer, both))).part == "left_shin"


def test_a_part_unseen_for_a_moment_is_not_worth_a_word() -> None:
    assert verdict(outcome(), hidden("head", 4, 4)).kind == "good"


def test_lost_comes_before_unseen() -> None:
    strong = np.full((N + 1, MARKS), FAR)
    found = verdict(outcome(strong, strong[1:]), hidden("head", 0, N - 1))
    assert found.kind == "lost"


@pytest.mark.parametrize("what", ["both ways", "pass", "refinement"])
def test_a_segment_of_which_a_pass_diverged_is_not_good(what: str) -> None:
    assert verdict(outcome(diverged=True, what=what)).kind != "good"


@pytest.mark.parametrize("nothing", ["apart", "drift"])
def test_evidence_that_is_no_number_is_not_good(nothing: str) -> None:
    none = np.full((N + 1, MARKS), np.nan)
    found = outcome(none) if nothing == "apart" else outcome(drift=none[1:])
    assert verdict(found).kind != "good"


def test_chains_that_could_not_be_followed_are_lost_whatever_was_kept() -> None:
    assert verdict(outcome(followed=False, what="refinement")).kind == "lost"


def test_neighbouring_keyframes_that_contradict_each_other_are_reported_as_such() -> None:
    segment = Segment(FIRST, FIRST + 1, START, END, Clip(FIRST, ()))
    wild = np.full((2, MARKS), FAR)
    path = interpolate(START, END, FIRST, FIRST + 1)
    found = Outcome((Pass("pass", path, 3.0),), 0, wild, wild[1:], False, False, 0.0)
    reported = judge(SCENE, segment, found, unobserved(SCENE, segment.clip, path))
    assert reported == Verdict.contradiction(FIRST, FIRST + 1)
    assert reported.go == FIRST
    uncertain = judge(
        SCENE, segment, replace(found, followed=True), unobserved(SCENE, segment.clip, path)
    )
    assert uncertain.frames is None or uncertain.frames[0] <= uncertain.frames[1]


def test_a_body_that_is_nowhere_to_be_seen_is_lost() -> None:
    seen = clear()
    none = replace(
        seen,
        shown=np.zeros_like(seen.shown),
        diagnostics=replace(seen.diagnostics, rank=np.zeros_like(seen.diagnostics.rank)),
    )
    found = verdict(outcome(), none)
    assert found == Verdict.nothing_seen(FIRST, LAST)
    assert found.go is None


def test_a_body_too_small_or_too_far_away_to_be_seen_is_never_good() -> None:
    poses = [Pose.rest(SKELETON, (x, 0.0, 9000.0)) for x in (0.0, 0.2)]
    path = interpolate(*poses, FIRST, LAST)
    found = replace(outcome(), passes=(Pass("pass", path, 3.0),))
    assert verdict(found) == Verdict.nothing_seen(FIRST, LAST)


def filmed(pictures: list[NDArray[np.uint8]]) -> Segment:
    """The segment with these pictures, one after the other."""
    prepared = [prepare(picture, None, 3) for picture in pictures]
    levels = tuple(np.stack(level) for level in zip(*prepared, strict=True))
    return replace(SEGMENT, clip=Clip(FIRST, levels))


def test_black_pictures_and_noise_show_nothing_and_something_small_that_moves_fast_does() -> None:
    noise, shape = np.random.default_rng(1), (N + 1, 96, 128)
    black, moving = np.zeros(shape, np.uint8), np.full(shape, 20, np.uint8)
    for n in range(N + 1):
        moving[n, 20:44, 5 * n : 5 * n + 20] = 200 if n % 2 else 120
        moving[n] = np.roll(moving[n], 40 * n, axis=0)
    for pictures in (black, noise.integers(0, 256, shape, np.uint8)):
        found = judge(SCENE, filmed(list(pictures)), outcome(), clear())
        assert found == Verdict.nothing_seen(FIRST, LAST)
    assert judge(SCENE, filmed(list(moving)), outcome(), clear()) == GOOD


def test_a_pass_that_diverged_is_a_reason_to_check_all_of_the_segment() -> None:
    found = verdict(outcome(diverged=True))
    assert found == Verdict.check("diverged", (FIRST, LAST))


def test_of_frames_that_are_damaged_the_longest_run_is_to_be_checked() -> None:
    clip = Clip(FIRST, (), frozenset({103, 107, 108, 109}))
    segment = replace(SEGMENT, clip=clip)
    found = judge(SCENE, segment, outcome(), clear())
    assert found == Verdict.check("damaged", (107, 109))


def silhouette(frames: slice, share: float, throughout: float = 0.0) -> SilhouetteMismatch:
    """Of the body's area, what moves beside the trunk in some frames."""
    beside = np.zeros((N + 1, SKELETON.part_count))
    beside[:, 0] = throughout
    beside[frames, 0] += share
    return SilhouetteMismatch(beside, np.zeros_like(beside))


def test_what_moves_beside_the_body_is_to_be_checked_at_the_worst_frame() -> None:
    mismatch = silhouette(slice(6, 13), 0.1)
    mismatch.uncovered_by_part[8:11, 0] += 0.05
    found = verdict(replace(outcome(), silhouette=mismatch))
    assert (found.kind, found.cause, found.part) == ("check", "moves_beside_body", None)
    assert found.frames == (FIRST + 6, FIRST + 12)
    assert found.go is not None
    assert FIRST + 8 <= found.go <= FIRST + 10


@pytest.mark.parametrize(
    "mismatch",
    [
        silhouette(slice(6, 13), 0.05),  # clothes
        silhouette(slice(6, 8), 0.5),  # a flash
        silhouette(slice(0, 0), 0.0, throughout=0.3),  # a shadow that goes along
        SilhouetteMismatch(*np.full((2, N + 1, SKELETON.part_count), np.nan)),
    ],
)
def test_what_right_poses_have_as_well_is_good(mismatch: SilhouetteMismatch) -> None:
    assert verdict(replace(outcome(), silhouette=mismatch)) == GOOD


def test_what_names_a_part_is_reported_before_what_moves_beside_the_body() -> None:
    mismatch = silhouette(slice(6, 13), 0.3)
    found = verdict(replace(outcome(), silhouette=mismatch), hidden("left_forearm", 3, 9))
    assert found.cause == "not_seen"


def with_joints(
    apart: float, distance: float = 0.01, drift: float = 0.0003, strays: float = 0.03
) -> Outcome:
    """Tracked with keypoints: a shoulder, an elbow, and a wrist that is less sure than both."""
    parts = np.array([SKELETON.body.index(f"left_{n}") for n in ("upper_arm", "forearm", "hand")])
    shape = (N + 1, 3)
    away, seen, led = np.full(shape, distance), np.full(shape, 0.9), np.full(shape, drift)
    away[8:12, 2] += strays
    led[8:12, 2] *= 3
    joints = JointEvidence(parts, away, seen, np.full(shape, apart), led, 200.0)
    return replace(outcome(), joints=joints)


def test_where_pictures_and_both_starts_agree_it_is_good_though_keypoints_are_elsewhere() -> None:
    assert verdict(with_joints(0.001, distance=0.035)) == GOOD


def test_where_they_do_not_the_joint_is_named_that_is_wrong_most_likely() -> None:
    found = verdict(with_joints(0.02, drift=0.004))
    assert (found.kind, found.cause, found.part) == ("check", "uncertain", "left_hand")
    assert found.frames is not None
    assert found.frames[0] <= FIRST + 8 <= FIRST + 11 <= found.frames[1]


@pytest.mark.parametrize(("distance", "kind"), [(0.002, "good"), (0.07, "check")])
def test_from_one_start_keypoints_alone_decide(distance: float, kind: str) -> None:
    assert verdict(with_joints(np.nan, distance, strays=0.0)).kind == kind


def with_depth(sigma_m: float, part: str = "left_forearm", rows: slice = slice(5, 16)) -> Outcome:
    """Tracked well in the picture; how far away is known to 4 mm, a joint's to `sigma_m`."""
    names = ("waist", "chest", "left_thigh", "left_shin", "left_upper_arm", "left_forearm")
    names += tuple(name.replace("left", "right") for name in names[2:])
    parts = np.array([SKELETON.body.index(name) for name in names])
    shape = (N + 1, len(parts))
    depth = np.full(shape, 0.004)
    depth[rows, names.index(part)] = sigma_m
    joints = JointEvidence(
        parts, np.full(shape, 0.01), np.full(shape, 0.9), np.full(shape, 0.001),
        np.full(shape, 0.0003), 200.0, depth_sigma_m=depth,
    )  # fmt: skip
    return replace(outcome(), joints=joints)


def test_what_is_right_in_the_picture_and_a_guess_in_depth_is_not_good() -> None:
    assert verdict(with_depth(0.03)) == GOOD
    found = verdict(with_depth(0.2))
    assert (found.kind, found.cause, found.part) == ("check", "depth", "left_forearm")
    assert found.frames == (FIRST + 5, FIRST + 15)
    assert found.go is not None
    assert verdict(with_depth(0.2, rows=slice(5, 7))) == GOOD  # two frames are no run


def test_a_part_that_is_a_guess_now_and_then_hides_no_other_that_is_one_for_long() -> None:
    outcome_ = with_depth(0.2, "right_forearm", slice(4, 9))
    assert outcome_.joints is not None
    assert outcome_.joints.depth_sigma_m is not None
    elbow = np.flatnonzero(outcome_.joints.parts == SKELETON.body.index("left_forearm"))
    outcome_.joints.depth_sigma_m[1::2, elbow] = 0.6
    found = verdict(outcome_)
    assert (found.part, found.frames) == ("right_forearm", (FIRST + 4, FIRST + 8))


def test_a_picture_that_is_wrong_is_said_first() -> None:
    unsure = with_depth(0.2)
    assert unsure.joints is not None
    unsure.joints.apart[:, 3] = 0.05
    unsure.joints.drift[:, 3] = 0.01
    assert verdict(unsure).cause == "uncertain"


def by_part(seconds: Floats) -> Floats:
    """The same of every part."""
    return seconds[:, None] * np.ones(SKELETON.part_count)


def test_a_pose_that_a_person_set_makes_the_depth_near_it_good() -> None:
    away = np.minimum(np.arange(N + 1), np.arange(N + 1)[::-1])
    posed = replace(SEGMENT, to_posed_s=by_part(away / 200.0))  # a quick film: all lies near
    assert judge(SCENE, SEGMENT, with_depth(0.2), clear()).cause == "depth"
    assert judge(SCENE, posed, with_depth(0.2), clear()) == GOOD
    limb = np.full((N + 1, SKELETON.part_count), np.inf)
    arm = [SKELETON.body.index(f"left_{name}") for name in ("upper_arm", "forearm", "hand")]
    limb[:, arm] = 0.0  # the arm alone was posed
    assert judge(SCENE, replace(SEGMENT, to_posed_s=limb), with_depth(0.2), clear()) == GOOD
    slow = replace(SEGMENT, to_posed_s=by_part(away / 10.0))
    assert judge(SCENE, slow, with_depth(0.2), clear()).cause == "depth"


@pytest.mark.parametrize(("away", "kind"), [(0.03, "good"), (0.09, "check")])
def test_a_foot_that_hangs_beside_where_it_is_seen_is_named(away: float, kind: str) -> None:
    good = with_depth(0.004)
    assert good.joints is not None
    foot = SKELETON.body.index("right_foot")
    feet = replace(
        good.joints, foot_distance=np.full((N + 1, 1), away), foot_parts=np.array([foot])
    )
    found = verdict(replace(good, joints=feet))
    assert found.kind == kind
    assert found.part == ("right_foot" if kind == "check" else None)
