"""`keypose draft`: a session with drafts, and nothing at all where it is left or refused."""

from __future__ import annotations

import json
import re
import shutil
import signal
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.app.cli import draft
from keypose.app.cli.main import main
from keypose.tracker.body.modify import height
from keypose.tracker.fitting.draft import DraftProgress
from keypose.tracker.keypoints import find_people
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.storage.sidecars import keypoints_of_session
from tests.app.cli_cases import everything_in, refused
from tests.tracker.keypoints.keypoint_cases import BALANCE, BOX, balance

VIDEO = BALANCE / "balance.mp4"
AROUND = ",".join(f"{value:g}" for value in BOX)
NEARLY = ",".join(f"{edge:g}" for edge in np.add(BOX, (6, -6, 6, 6)))
FILM_WIDTH = 544
BESIDE = ",".join(f"{edge:g}" for edge in np.add(BOX, (FILM_WIDTH, 0, FILM_WIDTH, 0)))
"""Around the same man in the same picture on its right."""


def command(out: Path, *more: str, box: str = AROUND) -> list[str | Path]:
    return ["draft", VIDEO, "--box", box, "--frames", "0-5", "--out", out, *more]


def run(arguments: list[str | Path]) -> int:
    return main([str(argument) for argument in arguments])


def test_a_session_with_drafts_and_its_keypoints_are_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new"
    taken = ("--recorded-fps", "240", "--deinterlace", "no")
    assert run(command(out, "--frame", "2", "--body", "elderly_male", *taken)) == 0
    session = load_session(out / "session.json")
    assert [draft.frame for draft in session.subject.drafts] == list(range(6))
    assert session.subject.keyframes == ()
    assert session.subject.body.name == "elderly_male"
    assert (session.view.video.recorded_fps, session.view.video.deinterlace) == (240.0, False)
    assert session.subject.drafts[5].time_s == pytest.approx(5 / 240)
    assert session.view.keypoints is not None
    assert session.view.keypoints.seeds == (2,)
    assert session.view.keypoints.network
    keypoints = keypoints_of_session(session, out)
    assert keypoints is not None
    assert (keypoints.first_frame, keypoints.last_frame) == (0, 5)
    with open_video_of(session, out / "session.json") as video:
        assert video.info.frame_count == session.view.video.frame_count
    message = capsys.readouterr().out
    assert "Drafts at 6 of 6 frames." in message
    assert "frame 0: first frame of the draft" in message
    assert f"Written: {out / 'session.json'}" in message


def test_json_gives_the_progress_and_the_frames_to_confirm(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(command(tmp_path / "new", "--json", "--field-of-view", "60")) == 0
    events = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {event["event"] for event in events[:-1]} == {"progress"}
    assert events[-1]["drafts"] == 6
    assert events[-1]["missing"] == []
    assert events[-1]["proposals"][0] == {"frame": 0, "reason": "start", "parts": []}
    assert load_session(tmp_path / "new" / "session.json").view.camera.origin == "field of view"


WRONG: dict[str, tuple[tuple[str, ...], str, str]] = {
    "a box outside": ((), "3000,10,3100,90", "outside the picture"),
    "a box without size": ((), "10,10,10,10", "has no size"),
    "a box of words": ((), "here", "is not a box"),
    "a box of three numbers": ((), "10,20,30", "is not a box"),
    "a box with nobody in it": ((), "0,0,60,60", "No person was found at frame 0"),
    "a second box with nobody in it": (("--box", "0,0,60,60"), AROUND, "No person was found"),
    "a second box outside": (("--box", "3000,10,3100,90"), AROUND, "outside the picture"),
    "two boxes around one": (("--box", AROUND), AROUND, "around the same person"),
    "two that nearly are one": (("--box", NEARLY), AROUND, "around the same person"),
    "a box and everyone": (("--everyone",), AROUND, "--everyone means all who are found"),
    "a frame that is not to be drafted": (("--frame", "9"), AROUND, "one of those to draft"),
    "frames beyond the video": (("--frames", "0-5000"), AROUND, "within those of the video"),
    "frames that fall": (("--frames", "5-2"), AROUND, "are no frames such as 10-60"),
    "no range": (("--frames", "5"), AROUND, "are no frames such as 10-60"),
    "no body": (("--body", "giant"), AROUND, "invalid choice: 'giant'"),
    "no angle": (("--field-of-view", "200"), AROUND, "not an angle"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_cannot_be_drafted_is_said_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: str
) -> None:
    more, box, words = WRONG[wrong]
    assert words in refused(capsys, tmp_path, command(tmp_path / "new", *more, box=box))
    assert not (tmp_path / "new").exists()


@pytest.fixture
def duet(tmp_path: Path) -> Path:
    """The man twice beside himself, as a folder of images."""
    folder = tmp_path / "duet"
    folder.mkdir()
    with balance() as video:
        for number in range(6):
            picture = np.hstack([video.frame(number)] * 2)[..., ::-1]
            cv2.imwrite(str(folder / f"{number:04}.jpg"), picture)
    return folder


def test_people_in_several_boxes_become_bodies_with_their_own_keypoints(
    duet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, boxes = tmp_path / "out", ("--box", AROUND, "--box", BESIDE)
    assert run(["draft", duet, *boxes, "--out", out, "--accept"]) == 0
    message = capsys.readouterr().out
    assert re.search(r"body:\nDrafts at 6 of 6 frames.*body-2:\nDrafts at 6 of 6", message, re.S)
    place = out / "session.json"
    session = load_session(place)
    assert [body.id for body in session.bodies] == ["body", "body-2"]
    middles = []
    for body in session.bodies:
        alone = session.about(body.id)
        assert [keyframe.frame for keyframe in body.keyframes][::5] == [0]
        assert all(keyframe.drafted for keyframe in body.keyframes)
        keypoints = keypoints_of_session(alone, out)
        assert keypoints is not None
        middles.append(np.median(keypoints.uv[..., 0]))
        assert alone.view.keypoints is not None
        assert str(out / alone.view.keypoints.file) in message
    assert middles[1] - middles[0] == pytest.approx(FILM_WIDTH, abs=5)
    assert run(["track", place, "--quality", "preview"]) == 0
    tracked = load_session(place)
    assert [body.results is not None for body in tracked.bodies] == [True, True]
    assert tracked.view.keypoints == session.view.keypoints
    assert tracked.bodies[1].keypoints_by_view == session.bodies[1].keypoints_by_view


def test_everyone_who_is_found_becomes_a_body_and_all_of_them_are_run(
    duet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    run_all = ["run", duet, "--out", out, "--quality", "preview", "--export", "npz", "--everyone"]
    assert run([*run_all, "--workers", "1", "--frame", "0"]) == 0
    told = capsys.readouterr().out
    assert re.search(r"2 people found: --box \S+ --box \S+ --frame 0", told), told
    (place,) = out.rglob("session.json")
    session = load_session(place)
    assert [body.id for body in session.bodies] == ["body", "body-2"]
    assert all(body.results is not None for body in session.bodies)
    assert re.search(r"body-2 \(adult_male\): \d \w+ of \d segment", told), told
    assert {"body.npz", "body-2.npz"} <= {file.name for file in out.rglob("*.npz")}


def test_json_tells_each_body_of_several(
    duet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    boxes = ("--box", AROUND, "--box", BESIDE, "--frames", "0-2")
    assert run(["draft", duet, *boxes, "--out", tmp_path / "out", "--json"]) == 0
    finished = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert [(each["body"], each["drafts"]) for each in finished["bodies"]] == [
        ("body", 3),
        ("body-2", 3),
    ]
    assert run(["draft", tmp_path / "out", "--accept", "--json"]) == 0
    accepted = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert [each["body"] for each in accepted["bodies"]] == ["body", "body-2"]
    assert all(each["accepted"] for each in accepted["bodies"])


def test_a_session_that_is_there_is_not_overwritten_unless_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "session.json").write_text("mine")
    assert "exists already" in refused(capsys, tmp_path, command(tmp_path))
    assert run(command(tmp_path, "--overwrite")) == 0
    assert (tmp_path / "session.json.previous").read_text() == "mine"


def test_ctrl_c_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = draft.drafted_people

    def interrupted(session: Session, *given: Any, **named: Any) -> Any:
        signal.raise_signal(signal.SIGINT)
        return whole(session, *given, **named)

    monkeypatch.setattr(draft, "drafted_people", interrupted)
    before = everything_in(tmp_path)
    assert run(command(tmp_path / "new")) == 130
    assert everything_in(tmp_path) == before
    assert "Interrupted" in capsys.readouterr().err


def test_ctrl_c_keeps_what_the_network_has_looked_at_and_the_same_command_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    whole, reports = draft.drafted_people, 0

    def interrupted(*given: Any, **named: Any) -> Any:
        def report(progress: DraftProgress) -> None:
            nonlocal reports
            reports += 1
            if reports == 25:
                signal.raise_signal(signal.SIGINT)
            named["report"](progress)

        return whole(*given, **{**named, "report": report})

    monkeypatch.setattr(draft, "drafted_people", interrupted)
    out = tmp_path / "new"
    some = command(out, "--json", "--frames", "0-39")
    assert run(some) == 130
    end = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert end["left"] == list(range(17, 40))
    found = load_session(out / "session.json").subject.drafted
    assert found is not None
    assert found.rest is not None
    assert [(r.first_frame, r.last_frame) for r in found.rest.frames] == [(17, 39)]
    assert run([*some, "--overwrite"]) == 0
    found = load_session(out / "session.json").subject.drafted
    assert found is not None
    assert found.rest is None


def test_without_a_box_the_one_person_in_the_film_is_found_and_that_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new"
    named = ("--height", "181", "--lens", "40", "--out", out)
    assert run(["draft", VIDEO, "--frames", "0-5", *named]) == 0
    session = load_session(out / "session.json")
    assert [draft.frame for draft in session.subject.drafts] == list(range(6))
    assert height(session.subject.body) == pytest.approx(1.81)
    assert session.view.camera.focal_mm == pytest.approx(40)
    assert session.view.lens_source == "person"
    words = capsys.readouterr().err
    found = re.search(r"One person found: --box ([\d,]+) --frame (\d)\.", words)
    assert found is not None
    assert np.array(found[1].split(","), float) == pytest.approx(np.array(BOX), abs=60)


NOT_ONE = {
    "several": ("walk", "2 people are to be seen at frame 25"),
    "nobody": ("box", "No person was found in the film"),
}


@pytest.mark.parametrize("who", NOT_ONE)
def test_several_people_are_listed_and_nobody_is_said(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    who: str,
) -> None:
    monkeypatch.setattr(find_people, "FRAMES", 2)
    sample, words = NOT_ONE[who]
    video = BALANCE.parent / sample / f"{sample}.mp4"
    at = ("--frame", "25") if who == "several" else ()
    message = refused(capsys, tmp_path, ["draft", video, *at, "--out", tmp_path / "new"])
    assert words in message
    assert not (tmp_path / "new").exists()
    if who == "several":
        left, right = re.findall(r"--box ([\d,]+)", message)
        assert int(left.split(",")[0]) < int(right.split(",")[0])


def test_drafts_are_accepted_as_soft_keyframes_with_their_very_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plain, at_once = tmp_path / "plain", tmp_path / "at_once"
    assert run(command(plain)) == 0
    drafts = {d.frame: d for d in load_session(plain / "session.json").subject.drafts}
    assert run(["draft", plain, "--accept"]) == 0
    assert run(command(at_once, "--accept")) == 0
    words = "Drafts accepted as approximate keyframes: 0, 5."
    assert capsys.readouterr().out.count(words) == 2
    one, other = (load_session(folder / "session.json") for folder in (plain, at_once))
    assert one.subject == other.subject
    soft = {"soft": True}
    assert one.subject.keyframes == tuple(drafts[f].model_copy(update=soft) for f in (0, 5))
    assert [draft.frame for draft in one.subject.drafts] == [1, 2, 3, 4]


NOT_ACCEPTED: dict[str, tuple[tuple[str, ...], str]] = {
    "a session without drafts": (("--accept",), "has no drafts to accept"),
    "a session that is not to be accepted": ((), "accepted with --accept alone"),
    "a session and a folder for another": (("--accept", "--out", "there"), "--accept alone"),
}


@pytest.mark.parametrize("wrong", NOT_ACCEPTED)
def test_what_cannot_be_accepted_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: str
) -> None:
    more, words = NOT_ACCEPTED[wrong]
    shutil.copy(BALANCE / "session.json", tmp_path)
    assert words in refused(capsys, tmp_path, ["draft", tmp_path, *more])


def test_drafts_that_are_left_once_those_proposed_are_accepted_are_not_denied(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(command(tmp_path, "--accept")) == 0
    capsys.readouterr()
    words = refused(capsys, tmp_path, ["draft", tmp_path, "--accept"])
    assert "has no proposed drafts left to accept; confirm its 4 other drafts" in words


def test_tracking_drafts_says_how_they_become_keyframes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(command(tmp_path)) == 0
    capsys.readouterr()
    words = refused(capsys, tmp_path, ["track", tmp_path])
    assert "has no keyframes; tracking needs two" in words
    assert f"`keypose draft {tmp_path / 'session.json'} --accept`" in words
