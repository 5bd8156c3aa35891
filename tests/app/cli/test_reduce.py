"""`keypose reduce`: a session's motion becomes keyframes in its file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Keyframe
from keypose.tracker.storage.files import load_session, save_session
from tests.app.serving import ROOT

PERSON = ROOT / "sample_videos" / "person"


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """The sample's true motion as drafts between two keyframes, its frames 30 to 32 without any."""
    (tmp_path / "person.mp4").write_bytes((PERSON / "person.mp4").read_bytes())
    sample = load_session(PERSON / "session.json")
    skeleton, truth = Skeleton.of(sample.subject.body), np.load(PERSON / "truth.npz")
    poses = zip(truth["Rs_parent_part"], truth["ps_camera_root"], strict=True)
    dense = [Keyframe.of(skeleton, Pose(*pose), n, n / 30) for n, pose in enumerate(poses)]
    drafts = [
        each.model_copy(update={"drafted": True})
        for each in dense[1:-1]
        if each.frame not in (30, 31, 32)
    ]
    given = {"keyframes": (dense[0], dense[-1]), "drafts": tuple(drafts)}
    save_session(sample.changed(given), tmp_path / "session.json")
    return tmp_path / "session.json"


def test_the_session_gets_the_keyframes_that_are_printed(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = load_session(session).subject.keyframes
    assert main(["reduce", str(session), "--tolerance", "6cm", "--dry-run", "--json"]) == 0
    reported = json.loads(capsys.readouterr().out)
    assert load_session(session).subject.keyframes == before
    assert main(["reduce", str(session), "--tolerance", "6cm"]) == 0
    words = capsys.readouterr().out
    saved = load_session(session)
    assert [keyframe.frame for keyframe in saved.subject.keyframes] == reported["frames"]
    assert (saved.subject.keyframes[0], saved.subject.keyframes[-1]) == before
    assert saved.subject.drafts == ()
    assert (reported["kept"], reported["frames_without_a_pose"]) == (2, 3)
    count = len(reported["frames"])
    assert f"{count} keyframes for 70 drafted frames, 2 of them there before" in words
    assert "3 frames have no pose" in words
    assert saved.subject.first_motion is not None
    assert [(run.first_frame, run.last_frame) for run in saved.subject.first_motion.own] == [
        (0, 29),
        (33, 72),
    ]
    assert session.with_name(saved.subject.first_motion.file).is_file()


def test_one_keyframe_in_twenty_frames_where_nothing_else_is_asked_for(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reduce", str(session), "--dry-run"]) == 0
    assert main(["reduce", str(session), "--every", "36", "--dry-run", "--json"]) == 0
    words, reported = capsys.readouterr().out.split("\n{", 1)
    assert "4 keyframes for 70 drafted frames, 2 of them there before: one in 24.0 frames." in words
    assert "The motion between them stays as it is" in words
    facts = json.loads("{" + reported)
    assert facts["frames_per_keyframe"] == 36
    assert facts["off_cm"] > 2
    assert facts["off_px"] is None


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["--tolerance", "2"], "'2' is not a distance such as 2cm"),
        (["--every", "0"], "'0' is not a whole number from 1 on"),
        (["--every", "9", "--tolerance", "2cm"], "not allowed with argument"),
        (["--tolerance", "0cm"], "The tolerance must be at least 0.1 mm"),
        (["--tolerance", "1px,0.02m", "--frames", "70-99"], "The video has frames 0 to 72"),
        (["--frames", "7"], "are no frames such as 10-60"),
        (["--frames", "30-32"], "There is no motion to reduce in these frames"),
        (["--from", "imported"], "No motion has been imported"),
        (["--limb", "tail"], "The body has no part 'tail'"),
    ],
)
def test_what_cannot_be_done_is_said_in_a_sentence(
    session: Path, capsys: pytest.CaptureFixture[str], given: list[str], words: str
) -> None:
    before = session.read_bytes()
    try:
        code = main(["reduce", str(session), *given])
    except SystemExit as exited:
        code = int(str(exited.code))
    assert code == 2
    assert words in capsys.readouterr().err
    assert session.read_bytes() == before
