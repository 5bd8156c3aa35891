"""A session that was tracked by the version before opens with its verdicts, at every door.

The files beside this one are as that version wrote them: the sample's box between five keyframes,
of which the one at 12 was set wrong.
"""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.editor.known import KnownMotion
from keypose.app.editor.state import EditorState
from keypose.app.posing import opening_pose
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.migrate import PRESENT
from keypose.tracker.session.verdict import GOOD, Verdict
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.results import load_results, save_results
from tests.app.serving import ROOT
from tests.tracker.session_cases import written

HERE = Path(__file__).parent / "version_2"
DIFFER = ": tracked from either keyframe, it differs"
SPANS = ((0, 6), (6, 12), (12, 18), (18, 19))
VERDICTS = [
    GOOD,
    Verdict.check("uncertain", (7, 11), "box"),
    Verdict.check("uncertain", (13, 17), "box"),
    GOOD,
]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    shutil.copytree(HERE, tmp_path / "old")
    shutil.copy(ROOT / "sample_videos" / "box" / "box.mp4", tmp_path / "old")
    return tmp_path / "old" / "session.json"


def _edit(path: Path) -> EditorState:
    session = load_session(path)
    return EditorState(
        doc=session,
        skeleton=Skeleton.of(session.subject.body),
        file_times_s=np.arange(session.view.video.frame_count) / 30,
        opening=opening_pose(session.subject.body, session.view.camera, (0.0, -1.0, 0.0)),
        motion=KnownMotion(load_results(session, path)),
    )


def test_its_verdicts_stand_where_they_stood(path: Path) -> None:
    session = load_session(path)
    assert session.subject.results is not None
    assert [segment.verdict for segment in session.subject.results.segments] == VERDICTS
    assert {segment.quality for segment in session.subject.results.segments} == {
        session.subject.results.quality
    }
    assert session.subject.results.quality == "full"  # fast, which was a quality between
    found = load_results(session, path).fitting(session)  # nothing of it is out of date
    assert {span: track.verdict for span, track in found.items()} == dict(
        zip(SPANS, VERDICTS, strict=True)
    )


def test_the_page_shows_them(path: Path) -> None:
    sections = Sections().changed(AppState(edit=_edit(path)))
    reported = [(s["state"], s["words"], s["part"], s["go"]) for s in sections["segments"]]
    assert reported == [
        ("good", "Good", None, None),
        ("check", f"Check: box may be wrong{DIFFER}", "box", 9),
        ("check", f"Check: box may be wrong{DIFFER}", "box", 15),
        ("good", "Good", None, None),
    ]
    assert sections["suggest"]["title"] == "Add a keyframe at 9"
    assert sections["suggest"]["detail"] == f"Box may be wrong, frames 7–11{DIFFER}"


def test_the_commands_say_them(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", str(path), "--format", "csv", "--out", str(tmp_path / "out")]) == 0
    with (tmp_path / "out" / "frames.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows[8]["words"] == "check frames 7–11: box uncertain"
    assert {row["words"] for row in rows} == {
        "good",
        "check frames 7–11: box uncertain",
        "check frames 13–17: box uncertain",
    }
    assert main(["report", str(path), "--out", str(tmp_path / "report.html")]) == 0
    assert "Check: box may be wrong" in (tmp_path / "report.html").read_text("utf-8")
    assert "traceback" not in capsys.readouterr().err.lower()


def test_saved_again_it_says_the_same_and_is_kept_as_it_was(path: Path) -> None:
    content, session = path.read_bytes(), load_session(path)
    results = load_results(session, path)
    save_session(save_results(session, path, results), path)
    data = written(path)
    assert data["schema_version"] == PRESENT
    assert [s["verdict"]["cause"] for s in data["results"]["segments"]] == [
        *("good", "uncertain", "uncertain", "good")
    ]
    assert path.with_name("session.json.v2").read_bytes() == content
    assert load_session(path).subject.results == session.subject.results
