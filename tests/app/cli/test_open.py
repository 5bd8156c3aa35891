"""`keypose open` as a page meets it: state in order, nothing lost, everything saved."""

from __future__ import annotations

import json
import shutil
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from keypose.tracker.storage.files import load_session
from tests.app.serving import ROOT, Keypose, Visitor


def copied(folder: Path) -> Path:
    """The session file of a copy of the person sample, its video beside it."""
    folder.mkdir()
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, folder)
    return folder / "session.json"


@pytest.fixture
def session(tmp_path: Path) -> Path:
    return copied(tmp_path / "person")


@pytest.fixture
def keypose(session: Path, tmp_path: Path) -> Iterator[Keypose]:
    running = Keypose(str(session), "--workspace", str(tmp_path / "workspace"))
    yield running
    running.end()


@pytest.fixture
def tab(keypose: Keypose) -> Iterator[Visitor]:
    visitor = Visitor(keypose)
    yield visitor
    visitor.leave()


@dataclass(frozen=True)
class Work:
    """A server, a session that it has just opened, and the one tab."""

    keypose: Keypose
    session: Path
    tab: Visitor


@pytest.fixture(scope="module")
def lasting(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Keypose, Path]]:
    """A server that several tests use one after the other, and a folder it may look into."""
    folder = tmp_path_factory.mktemp("lasting") / "person"
    running = Keypose(str(copied(folder)), "--workspace", str(folder / "workspace"))
    yield running, folder
    code, words = running.end()
    assert code == 0, words
    assert "Traceback" not in words, words


@pytest.fixture
def work(lasting: tuple[Keypose, Path], tmp_path: Path) -> Iterator[Work]:
    """That server with a session of one's own, and a tab that has come since."""
    keypose, folder = lasting
    session = copied(folder / tmp_path.name)
    opener = Visitor(keypose)
    # The folder that Keypose runs in is 0, that of the session it was begun with 1.
    opener.do(do="open", kind="file", id=f"1/{session.relative_to(folder)}")
    opener.until(lambda: (opener.seen["file"] or {}).get("path") == str(session))
    opener.do(do="live", on=False)
    opener.leave()
    tab = Visitor(keypose)
    tab.until(lambda: tab.seen["tabs"] == 1)
    yield Work(keypose, session, tab)
    tab.leave()


def turn(x: float, stroke: str | None = None) -> dict[str, object]:
    return {"do": "angles", "part": "left_forearm", "x": x, "stroke": stroke}


def angle_of(tab: Visitor) -> float:
    return float(tab.seen["pose"]["angles"]["left_forearm"][0])


def test_a_tab_receives_everything_when_it_comes(work: Work) -> None:
    tab = work.tab
    assert tab.seen["file"]["frames"] == 73
    assert tab.seen["keys"]["frames"] == [0, 24, 48, 72]
    assert len(tab.seen["body"]["parts"]) == len(tab.seen["pose"]["T"]) == 16
    assert [s["state"] for s in tab.seen["segments"]] == ["none"] * 3
    assert tab.seen["saved"]["state"] == "saved"


def test_500_rapid_edits_end_alike_on_the_page_on_the_server_and_on_disk(
    tab: Visitor, keypose: Keypose, session: Path
) -> None:
    for number in range(500):
        last = tab.send(**turn(-number / 5, "slide"))
    tab.send(do="end_stroke", stroke="slide")
    tab.until(lambda: tab.ack > last and tab.seen["pose"]["stroke"] is None)
    assert angle_of(tab) == pytest.approx(-499 / 5)
    tab.until(lambda: tab.seen["saved"]["state"] == "saved" and tab.seen["saved"]["at"] > 0)
    other = Visitor(keypose)
    assert angle_of(other) == pytest.approx(-499 / 5)
    other.leave()
    keypose.end()
    again = Keypose(str(session), "--workspace", str(session.parent / "w"))
    back = Visitor(again)
    assert angle_of(back) == pytest.approx(-499 / 5, abs=1e-6)
    back.leave()
    again.end()


def test_edits_of_one_tab_reach_the_others(work: Work) -> None:
    tab, other = work.tab, Visitor(work.keypose)
    assert other.seen["tabs"] == 2
    tab.do(**turn(-30))
    other.until(lambda: angle_of(other) == pytest.approx(-30))
    other.do(do="undo")
    tab.until(lambda: angle_of(tab) != pytest.approx(-30))
    other.leave()
    tab.until(lambda: tab.seen["tabs"] == 1)


def test_a_refused_action_says_why_and_changes_nothing(work: Work) -> None:
    tab = work.tab
    before = json.dumps(tab.seen["pose"])
    tab.do(do="angles", part="left_forearm", x=1e9)
    assert "x" in tab.refusal()
    tab.do(do="move_key", frame=24, to=48)
    assert tab.refusal() == "Frame 48 is already a keyframe. Delete it first."
    assert json.dumps(tab.seen["pose"]) == before


def test_what_is_no_message_does_not_disturb_the_others(work: Work) -> None:
    tab = work.tab
    for nonsense in ("[]", "7", '{"do": {}}', '{"do": "go", "frame": 1e300}', '{"n": "x"}'):
        tab.line.send(nonsense)
    tab.do(do="go", frame=5)
    assert tab.seen["view"]["frame"] == 5
    broken = Visitor(work.keypose)
    broken.line.send("{")
    tab.do(do="go", frame=6)
    assert tab.seen["view"]["frame"] == 6


def test_tracking_streams_passes_and_the_result_is_saved(work: Work) -> None:
    tab = work.tab
    tab.do(do="go", frame=12)
    tab.do(do="track", what="this")
    tab.until(lambda: tab.seen["pose"]["source"] == "tracked")
    tab.until(lambda: tab.seen["job"]["state"] == "done")
    assert tab.seen["segments"][0]["state"] in ("good", "check")
    assert [(first, len(values)) for first, *values in tab.seen["lanes"]["waist"]] == [(0, 25)]
    tab.until(lambda: tab.seen["saved"]["state"] == "saved")
    results = load_session(work.session).subject.results
    assert results is not None
    assert [(s.first_frame, s.last_frame) for s in results.segments] == [(0, 24)]


def test_a_changed_keyframe_makes_its_segments_outdated_and_undo_makes_them_good(
    work: Work,
) -> None:
    tab = work.tab
    tab.do(do="settings", quality="preview")
    tab.do(do="track", what="all")
    tab.until(lambda: tab.seen["job"]["state"] == "done")
    good = [s["state"] for s in tab.seen["segments"]]
    tab.do(do="go", frame=24)
    tab.do(**turn(-30))
    tab.until(lambda: tab.seen["segments"][0]["state"] == "outdated")
    assert [s["state"] for s in tab.seen["segments"]] == ["outdated", "outdated", good[2]]
    tab.do(do="undo")
    tab.until(lambda: [s["state"] for s in tab.seen["segments"]] == good)


def test_with_live_on_a_changed_keyframe_is_tracked_at_once(work: Work) -> None:
    tab = work.tab
    tab.do(do="live", on=True)
    tab.do(do="go", frame=24)
    tab.do(**turn(-5))
    tab.until(lambda: tab.seen["job"]["state"] == "done")
    kinds = [s["state"] for s in tab.seen["segments"]]
    assert kinds[2] == "none"
    assert set(kinds[:2]) <= {"good", "check", "lost"}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda n: n.name)
def test_a_signal_ends_it_with_everything_saved(
    tab: Visitor, keypose: Keypose, session: Path, number: signal.Signals
) -> None:
    tab.do(**turn(-33, "held"))
    code, words = keypose.end(number)
    assert code == 0
    assert "everything is saved" in words
    assert "Traceback" not in words
    forearm = load_session(session).subject.keyframes[0].rotations_wxyz["left_forearm"]
    assert forearm[0] == pytest.approx(0.9588, abs=1e-3)  # half of 33°


def test_without_a_name_it_waits_at_the_start_screen(tmp_path: Path) -> None:
    keypose = Keypose("--workspace", str(tmp_path))
    tab = Visitor(keypose)
    assert tab.seen["file"] is None
    tab.do(do="go", frame=3)
    assert tab.refusal() == "Open a video first."
    tab.do(do="open", kind="sample", id="box")
    tab.until(lambda: tab.seen["file"] is not None)
    assert tab.seen["file"]["name"] == "box"
    tab.do(do="close")
    tab.until(lambda: tab.seen["file"] is None)
    tab.leave()
    keypose.end()


def test_a_video_without_a_session_begins_one_beside_it(session: Path, tmp_path: Path) -> None:
    session.unlink()
    keypose = Keypose(str(session.with_name("person.mp4")), "--workspace", str(tmp_path / "w"))
    tab = Visitor(keypose)
    assert tab.seen["keys"] == {"frames": [], "drafts": [], "soft": [], "parts": []}
    assert tab.seen["guide"]["first"] is True
    tab.do(do="add_key", frame=0)
    tab.until(lambda: tab.seen["saved"]["state"] == "saved" and tab.seen["saved"]["at"] > 0)
    assert (
        len(load_session(session.parent / "person.keypose" / "session.json").subject.keyframes) == 1
    )
    tab.leave()
    keypose.end()


def test_with_out_the_session_of_a_folder_is_copied_and_the_copy_opened(
    session: Path, tmp_path: Path
) -> None:
    before, copy = session.read_bytes(), tmp_path / "copy"
    given = (str(session.parent), "--out", str(copy), "--workspace", str(tmp_path / "w"))
    with Keypose(*given) as running:
        visitor = Visitor(running)
        assert Path(visitor.seen["file"]["path"]) == copy / session.name
        visitor.leave()
    assert session.read_bytes() == before


def test_a_second_program_on_one_session_reads_only_and_says_who_writes(
    tab: Visitor, keypose: Keypose, session: Path
) -> None:
    second = Keypose(str(session), "--workspace", str(session.parent / "w"))
    reader = Visitor(second)
    reported = f"Read only: open in another Keypose (pid {keypose.process.pid}). Close it there "
    reported += "to edit it here."
    assert reader.seen["saved"] == {"state": "readonly", "at": 0.0, "words": reported}
    reader.do(do="go", frame=7)
    assert reader.seen["view"]["frame"] == 7
    for action in (turn(-20), {"do": "undo"}, {"do": "track", "what": "all"}):
        reader.do(**action)
        assert reader.refusal().startswith(reported)
    tab.do(**turn(-33))
    tab.until(lambda: tab.seen["saved"]["state"] == "saved" and tab.seen["saved"]["at"] > 0)
    reader.leave()
    second.end()
    assert load_session(session).subject.keyframes[0].rotations_wxyz["left_forearm"][0] > 0.9


def test_what_another_program_let_go_of_can_be_written_again(
    tab: Visitor, keypose: Keypose, session: Path
) -> None:
    keypose.end()
    second = Keypose(str(session), "--workspace", str(session.parent / "w"))
    writer = Visitor(second)
    assert writer.seen["saved"]["state"] == "saved"
    writer.leave()
    second.end()


def test_a_session_with_a_damaged_motion_opens_with_its_keyframes_and_says_so(
    tab: Visitor, keypose: Keypose, session: Path
) -> None:
    tab.do(do="settings", quality="preview")
    tab.do(do="track", what="all")
    tab.until(lambda: tab.seen["job"]["state"] == "done")
    keypose.end()
    for tracks in session.parent.glob("tracks-*.npz"):
        tracks.write_bytes(tracks.read_bytes()[:-9])
    again = Keypose(str(session), "--workspace", str(session.parent / "w"))
    back = Visitor(again)
    assert back.seen["keys"]["frames"] == [0, 24, 48, 72]
    assert [s["state"] for s in back.seen["segments"]] == ["none"] * 3
    assert "damaged" in back.replies[0]["words"]
    back.leave()
    again.end()
