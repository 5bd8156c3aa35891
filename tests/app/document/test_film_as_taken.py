"""What a film's file does not say, or says wrongly, of how it was taken."""

from __future__ import annotations

import importlib.util
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.document.new import open_as_taken
from keypose.app.export.motion_formats import FORMATS
from keypose.app.export.report.derivatives import derivatives_section
from keypose.app.export.report.gait import gait_section
from keypose.app.export.report.subject import recording_of, subject_of
from keypose.app.store.store import Store
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from tests.app.document.test_edit_log import done
from tests.app.walking_cases import write_walk
from tests.scenes import opened_store
from tests.tracker import session_cases as cases
from tests.tracker.session_cases import written
from tests.tracker.video.test_fields import write_interlaced
from tests.tracker.video_cases import numbered_picture, write_image, write_numbered

SLOW_MOTION = {"recorded_fps": 240.0}
NEEDED = {name: kind.library[1] for name, kind in FORMATS.items() if kind.library}
"""Formats that need a library which may not be there, with its module."""


def taken(path: Path, **named: Any) -> Path:
    """The session's file of what lies there, once it says so."""
    return open_as_taken(path, lambda film: film.with_suffix(".keypose") / "session.json", named)


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """One walk, filmed at 240 frames a second: as slow motion at 30 of which that is said, and in a
    file of the true rate."""
    folder = tmp_path_factory.mktemp("slow")
    slow, _ = write_walk(folder / "slow" / "walk", "walk.mp4", rate=30)
    true, _ = write_walk(folder / "true" / "walk", "walk.mp4", rate=240)
    taken(slow, **SLOW_MOTION)
    return slow, true


def exported(path: Path, out: Path) -> Mapping[str, bytes]:
    formats = [f for f in FORMATS if not (f in NEEDED and not importlib.util.find_spec(NEEDED[f]))]
    arguments = ["--format", ",".join(formats), "--filter", "6Hz", "--out", str(out)]
    assert main(["export", str(path), *arguments]) == 0
    return {file.name: file.read_bytes() for file in out.iterdir()}


def test_slow_motion_is_exported_with_the_times_of_a_film_at_its_true_rate(
    walks: tuple[Path, Path], tmp_path: Path
) -> None:
    slow, true = (exported(path, tmp_path / name) for path, name in zip(walks, "ab", strict=True))
    assert slow.keys() == true.keys()
    assert {name for name in slow if slow[name] != true[name]} <= {"motion.npz"}
    one, other = (np.load(io.BytesIO(files["motion.npz"])) for files in (slow, true))
    np.testing.assert_allclose(one["time_s"], other["time_s"], atol=1e-12)
    assert b"\n152,0.633333" in slow["joints.csv"]


def test_slow_motion_has_the_speeds_and_the_gait_of_a_film_at_its_true_rate(
    walks: tuple[Path, Path],
) -> None:
    found = []
    for path in walks:
        session = load_session(path)
        with open_video_of(session, path) as video:
            subject = subject_of(session, path, video.info)
        recording = recording_of(subject)
        assert recording is not None
        found.append((gait_section(subject, recording), derivatives_section(subject)))
    assert found[0] == found[1]
    assert found[0][1] is not None


@pytest.mark.parametrize(("kind", "seconds"), [("images", 9 / 90), ("slow motion", 9 / 30)])
def test_a_film_of_images_has_their_rate_and_one_of_slow_motion_stays_slow(
    tmp_path: Path, kind: str, seconds: float, capsys: pytest.CaptureFixture[str]
) -> None:
    path = cases.write_session(tmp_path / "job")
    if kind == "slow motion":
        film = write_numbered(tmp_path / "job" / "film.mp4", cases.FRAMES)
        cases.altered(path, lambda data: data["video"].update(path=film.name, fingerprint=""))
    taken(path, recorded_fps=90.0)
    assert main(["film", str(path), "--out", str(tmp_path / "out.mp4"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["seconds"] == pytest.approx(seconds, abs=1e-3)


def test_a_rate_is_kept_in_the_session_and_a_session_without_one_is_written_as_before(
    tmp_path: Path,
) -> None:
    path, _ = write_walk(tmp_path / "walk")
    before = path.read_bytes()
    save_session(load_session(path), path)
    assert path.read_bytes() == before
    taken(path, **SLOW_MOTION, deinterlace=False)
    video = written(path)["video"]
    assert (video["recorded_fps"], video["deinterlace"]) == (240.0, False)
    assert load_session(path).subject.keyframes[1].time_s == pytest.approx(51 / 240)


def test_a_new_film_and_a_folder_of_images_are_opened_with_the_rate_that_is_said(
    tmp_path: Path,
) -> None:
    film = write_numbered(tmp_path / "jump.mp4", 5)
    images = tmp_path / "shots"
    images.mkdir()
    for number in range(3):
        write_image(images / f"{number}.png", numbered_picture(number))
    for path, rate in ((film, 240.0), (images, 1000.0)):
        session = load_session(taken(path, recorded_fps=rate))
        assert session.evidence.times_s(None)[-1] == (session.view.video.frame_count - 1) / rate


async def test_the_page_sets_the_rate_and_undoes_it_also_after_it_was_opened_anew(
    tmp_path: Path,
) -> None:
    path, _ = write_walk(tmp_path / "films" / "walk")

    def facts(store: Store) -> tuple[float, float, float]:
        edit, tab = store.app_state.edit, store.join()
        assert edit is not None
        store.leave(tab)
        return edit.doc.subject.keyframes[-1].time_s, float(edit.times_s[-1]), edit.frame_count

    seen = []
    async with opened_store(path) as store:
        seen.append(facts(store))
        await done(store, {"do": "read_film", **SLOW_MOTION})
        seen.append(facts(store))
    async with opened_store(path) as store:
        assert facts(store) == seen[1]
        await done(store, {"do": "undo"})
        assert facts(store) == seen[0]
        await done(store, {"do": "redo"}, {"do": "read_film", "recorded_fps": None})
        assert facts(store) == seen[0]
    assert seen[0][:2] == pytest.approx((152 / 30, 152 / 30), abs=1e-3)
    assert seen[1][:2] == pytest.approx((152 / 240, 152 / 240))


async def test_the_page_shows_the_fields_woven_or_apart_as_it_is_said(tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    film = write_interlaced(tmp_path / "films" / "camcorder.mp4")
    async with opened_store(film) as store:
        assert store.opened is not None
        made = store.opened.video.frame(4)
        await done(store, {"do": "read_film", "deinterlace": False})
        woven = store.opened.video.frame(4)
        assert (made != woven).any()
        await done(store, {"do": "undo"})
        np.testing.assert_array_equal(store.opened.video.frame(4), made)
        await done(store, {"do": "redo"})
        path = store.opened.session_path
    with open_video_of(load_session(path), path) as video:
        np.testing.assert_array_equal(video.frame(4), woven)


def test_track_keeps_what_is_said_in_the_session_or_in_the_copy_that_it_tracks(
    session_path: Path, tmp_path: Path
) -> None:
    asked = ["track", str(session_path), "--recorded-fps", "480000/1001"]
    assert main([*asked, "--out", str(tmp_path / "copy")]) == 0
    assert load_session(session_path).view.video.recorded_fps is None
    assert main(asked) == 0
    for path in (session_path, tmp_path / "copy" / "session.json"):
        assert load_session(path).view.video.recorded_fps == pytest.approx(479.52, abs=0.001)


@pytest.mark.parametrize("rate", ["0", "-30", "1e9", "fast", "2000000"])
def test_a_rate_that_is_none_is_refused_in_a_sentence(
    session_path: Path, rate: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["track", str(session_path), f"--recorded-fps={rate}"])
    assert stop.value.code == 2
    assert "is not a rate from 0.001 to 1000000 frames a second" in capsys.readouterr().err


async def test_numbers_that_are_missing_among_images_are_told_when_these_are_opened(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "films" / "shots"
    folder.mkdir(parents=True)
    for number in (1, 2, 5):
        write_image(folder / f"{number}.png", numbered_picture(number))
    for _ in ("new", "again"):
        async with opened_store(folder) as store:
            message = (await store.join().next())[0]
            assert "numbers 3–4 missing" in message["words"]
