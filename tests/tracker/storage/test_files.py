"""The session file: what is read back, what is refused and in which words, what survives."""

from __future__ import annotations

import errno
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from keypose.tracker.errors import FormatError, SessionError
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import require_absent, require_folder, write_file
from keypose.tracker.storage.changes import apply_changes
from keypose.tracker.storage.files import (
    load_session,
    open_video_of,
    save_session,
    session_json,
    video_path,
)
from tests.tracker import session_cases as cases

Change = Callable[[dict[str, Any]], None]

SAMPLES = Path(__file__).resolve().parents[3] / "sample_videos"


def _set(*steps: str | int, to: object) -> Change:
    """Set one field of the file's JSON."""

    def change(data: Any) -> None:
        for step in steps[:-1]:
            data = data[step]
        data[steps[-1]] = to

    return change


def refusal(path: Path) -> str:
    with pytest.raises(SessionError) as caught:
        load_session(path)
    text = str(caught.value)
    assert text.endswith(".")
    assert "\n" not in text
    return text


def test_what_is_saved_is_read_back(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    session = cases.session()
    save_session(session, path)
    assert load_session(path) == session


@settings(deadline=None)
@given(st.floats(-1e5, 1e5), st.floats(0.06, 1e5))
def test_every_digit_of_a_number_survives(x: float, z: float) -> None:
    session = cases.session(keyframes=(0,))
    rest = session.subject.keyframes[0].model_copy(
        update={"rotations_wxyz": {}, "root_m": (x, 0.0, z)}
    )
    session = session.changed({"keyframes": (rest,)})
    assert Session.model_validate_json(session_json(session)) == session


def test_the_file_before_is_kept_as_previous(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    save_session(cases.session(), path)
    first = path.read_bytes()
    save_session(cases.session(keyframes=(0, 8)), path)
    assert (tmp_path / "session.json.previous").read_bytes() == first
    assert path.read_bytes() != first
    assert sorted(p.name for p in tmp_path.iterdir()) == ["session.json", "session.json.previous"]


def test_saving_the_same_again_keeps_the_previous(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    for keyframes in ((0, 4), (0, 8), (0, 8)):
        save_session(cases.session(keyframes=keyframes), path)
    assert len(load_session(tmp_path / "session.json.previous").subject.keyframes) == 2
    assert load_session(tmp_path / "session.json.previous").subject.keyframes[1].frame == 4


@pytest.mark.parametrize("step", ["os.fsync", "pathlib.Path.replace"])
def test_a_failure_on_the_way_leaves_the_old_file_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    path = tmp_path / "session.json"
    save_session(cases.session(), path)
    before = path.read_bytes()

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(step, full)
    with pytest.raises(SessionError, match=r"^No space left on device: '.*' cannot be written\.$"):
        save_session(cases.session(keyframes=(0, 8)), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["session.json"]


def test_saving_never_writes_through_a_link(tmp_path: Path) -> None:
    real = tmp_path / "real.json"
    save_session(cases.session(), real)
    before = real.read_bytes()
    link = tmp_path / "session.json"
    link.symlink_to(real)
    save_session(cases.session(keyframes=(0, 8)), link)
    assert real.read_bytes() == before
    assert len(load_session(link).subject.keyframes) == 2


def test_the_mode_of_the_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    save_session(cases.session(), path)
    path.chmod(0o640)
    save_session(cases.session(keyframes=(0, 8)), path)
    assert path.stat().st_mode & 0o777 == 0o640


def test_a_file_that_is_there_is_not_overwritten_unless_asked(tmp_path: Path) -> None:
    path = tmp_path / "picture.png"
    path.write_bytes(b"mine")
    with pytest.raises(FormatError, match="exists already"):
        write_file(path, b"new")
    with pytest.raises(FormatError, match="exists already"):
        require_absent([tmp_path / "other", path])
    assert path.read_bytes() == b"mine"
    write_file(path, b"new", overwrite=True)
    assert path.read_bytes() == b"new"
    assert [p.name for p in tmp_path.iterdir()] == ["picture.png"]


def test_asking_whether_a_folder_can_be_written_leaves_nothing(tmp_path: Path) -> None:
    require_folder(tmp_path / "not" / "yet" / "made")
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").write_text("")
    with pytest.raises(FormatError, match="cannot be written to"):
        require_folder(tmp_path / "file" / "folder")


REFUSED: dict[str, tuple[Change, str]] = {
    "that a newer Keypose wrote otherwise": (
        lambda data: data.update(schema_version=5, camera=7),
        "written by a newer Keypose (version 5), and here views.0.camera: should be an object",
    ),
    "of no known version": (
        _set("schema_version", to="first"),
        "schema_version must be a number from 1 to 4",
    ),
    "of a version before the first": (_set("schema_version", to=0), "from 1 to 4"),
    "without a version": (lambda data: data.pop("schema_version"), "schema_version is missing"),
    "without a camera": (lambda data: data.pop("camera"), "camera: field required"),
    "with a zero focal length": (_set("camera", "fx", to=0), "camera.fx"),
    "with NaN": (_set("camera", "fx", to=float("nan")), "camera.fx: input should be a finite"),
    "with an infinite place": (
        _set("keyframes", 0, "root_m", to=[0, 0, float("inf")]),
        "keyframes.0.root_m.2: input should be a finite",
    ),
    "with a far too distant place": (
        _set("keyframes", 0, "root_m", to=[0, 0, 1e300]),
        "keyframes.0.root_m.2",
    ),
    "with a rotation that is none": (
        _set("keyframes", 0, "rotations_wxyz", "trunk", to=[1e200, 0, 0, 1]),
        "not a unit quaternion",
    ),
    "with keyframes out of order": (
        lambda data: data["keyframes"].reverse(),
        "sort them by frame",
    ),
    "with two keyframes on a frame": (_set("keyframes", 1, "frame", to=0), "two keyframes"),
    "with a keyframe beyond the video": (_set("keyframes", 2, "frame", to=9), "beyond the video"),
    "with a body behind the camera": (
        _set("keyframes", 0, "root_m", to=[0, 0, -3]),
        "behind the camera",
    ),
    "with a camera of another size": (_set("camera", "width", to=640), "the sizes must agree"),
    "with a missing parent": (_set("body", "parts", 1, "parent", to="tail"), "which is missing"),
    "with parents in a circle": (
        _set("body", "parts", 2, "parent", to="left_hand"),
        "its own ancestor",
    ),
    "with a part without size": (
        _set("body", "parts", 1, "shape", "radius_m", to=0),
        "radius_m",
    ),
    "with a time before the video": (
        _set("keyframes", 0, "time_s", to=-0.1),
        "keyframes.0.time_s: input should be greater than or equal to 0",
    ),
    "with a time of another age": (
        _set("keyframes", 2, "time_s", to=1e9),
        "keyframes.2.time_s: input should be less than or equal to 10000000",
    ),
    "with times that stand still": (
        _set("keyframes", 1, "time_s", to=0),
        "time_s of frame 4 is 0; it must be later than 0, the time of frame 0",
    ),
    "with more frames than any video": (
        _set("video", "frame_count", to=10**9),
        "video.frame_count: input should be less than or equal to 100000000",
    ),
    "with a far too distant centre": (
        _set("camera", "cx", to=1e300),
        "camera.cx: input should be less than or equal to 1000000",
    ),
    "with a lens that bends too much": (
        _set("camera", "distortion", to=[0, 0, 0, -1e4, 0]),
        "camera.distortion.3: input should be greater than or equal to -1000",
    ),
    "with a telephoto camera too far away": (
        lambda data: data["camera"].update(projection="telephoto", telephoto_distance_m=1e6),
        "camera.telephoto_distance_m: input should be less than or equal to 100000",
    ),
    "with an odd hash": (
        _set(
            "results",
            to={
                "tracks": "tracks-000000000000.npz",
                "method": "keypose",
                "quality": "full",
                "segments": [],
                "tracked_for": "me",
            },
        ),
        "results.tracked_for",
    ),
    "with a tracks file elsewhere": (
        _set(
            "results",
            to={"tracks": "../x.npz", "method": "keypose", "quality": "full", "segments": []},
        ),
        "results.tracks",
    ),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_a_session_is_refused_in_one_sentence_that_names_file_and_field(
    tmp_path: Path, kind: str
) -> None:
    path = tmp_path / "session.json"
    save_session(cases.session(), path)
    change, words = REFUSED[kind]
    cases.altered(path, change)
    text = refusal(path)
    assert text.startswith("session.json: ")
    assert words in text


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is not JSON"),
        (b"{", "is not JSON"),
        (b"\xff\xfe\x00", "is not JSON"),
        (b"[" * 100_000, "is not JSON"),
        (b"[]", "is not a session"),
        (b"null", "is not a session"),
    ],
)
def test_what_is_not_a_session_is_refused(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "session.json"
    path.write_bytes(content)
    assert words in refusal(path)


def test_missing_files_and_folders_are_named(tmp_path: Path) -> None:
    assert "There is no session file" in refusal(tmp_path / "none.json")
    assert "is a folder" in refusal(tmp_path)
    assert "cannot be read" in refusal(tmp_path / "a\0b")


def test_a_file_far_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "movie.mp4"
    with path.open("wb") as file:
        file.truncate(10**9)
    assert "too large" in refusal(path)


def test_the_video_is_found_from_the_folder_of_the_session(tmp_path: Path) -> None:
    session = cases.session()
    assert video_path(session, tmp_path / "session.json") == tmp_path / "frames"
    there = session.view.video.model_copy(update={"path": str(tmp_path / "clips" / "a.mp4")})
    moved = session.changed({"video": there})
    assert video_path(moved, Path("session.json")) == tmp_path / "clips" / "a.mp4"


def test_the_video_of_the_session_opens(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path)
    with open_video_of(load_session(path), path) as video:
        assert video.frame(3).shape == (cases.HEIGHT, cases.WIDTH, 3)


def test_a_video_whose_fingerprint_is_not_yet_known_opens(tmp_path: Path) -> None:
    cases.write_frames(tmp_path / "frames")
    with open_video_of(cases.session(), tmp_path / "session.json") as video:
        assert video.info.frame_count == cases.FRAMES


def test_another_video_of_the_same_size_is_reported_by_its_fingerprint(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path)
    (tmp_path / "frames").rename(tmp_path / "old")
    cases.write_frames(tmp_path / "frames", brightness=30)
    with pytest.raises(SessionError, match=r"not the one .* \(fingerprint differs\)"):
        open_video_of(load_session(path), path)


def _film(folder: Path) -> Path:
    """A session of a film that is one file."""
    folder.mkdir()
    shutil.copyfile(SAMPLES / "box" / "box.mp4", folder / "box.mp4")
    shutil.copyfile(SAMPLES / "box" / "session.json", folder / "session.json")
    return folder / "session.json"


@pytest.mark.parametrize("place", ["renamed.mp4", "../box.mp4", "../other name.mp4"])
def test_a_video_that_was_moved_nearby_is_found_again(tmp_path: Path, place: str) -> None:
    path = _film(tmp_path / "take")
    (path.parent / "box.mp4").rename(path.parent / place)
    with open_video_of(load_session(path), path) as video:
        assert video.info.path.resolve() == (path.parent / place).resolve()


def test_another_video_in_its_place_is_not_taken_for_it(tmp_path: Path) -> None:
    path = _film(tmp_path / "take")
    (path.parent / "box.mp4").rename(path.parent / "mine.mp4")
    shutil.copyfile(SAMPLES / "person" / "person.mp4", path.parent / "box.mp4")
    with open_video_of(load_session(path), path) as video:
        assert video.info.path.name == "mine.mp4"
    (path.parent / "mine.mp4").unlink()
    with pytest.raises(SessionError, match="not the one"):
        open_video_of(load_session(path), path)


def test_a_video_of_another_length_size_or_place_is_refused(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path)
    cases.altered(path, _set("video", "frame_count", to=10))
    with pytest.raises(SessionError, match="9 frames instead of 10"):
        open_video_of(load_session(path), path)
    cases.altered(path, _set("video", "width", to=32))
    cases.altered(path, _set("camera", "width", to=32))
    with pytest.raises(SessionError, match="64×48 pixels instead of 32×48"):
        open_video_of(load_session(path), path)
    cases.altered(path, _set("video", "path", to="gone.mp4"))
    with pytest.raises(SessionError, match=r"gone\.mp4' is missing"):
        open_video_of(load_session(path), path)


def test_a_saved_session_is_plain_json(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    save_session(cases.session(), path)
    data = json.loads(path.read_text("utf-8"), parse_constant=pytest.fail)
    assert data["schema_version"] == 4


@pytest.mark.parametrize("field", ["keyframes", "drafts", "ignore_masks"])
def test_more_than_a_person_sets_is_refused_before_any_of_it_is_read(
    tmp_path: Path, field: str
) -> None:
    path = cases.write_session(tmp_path)
    cases.altered(path, _set(field, to=[{"not": "read"}] * 10_001))
    with pytest.raises(SessionError, match=f"{field}: 10001 are more than the 10000"):
        load_session(path)


def test_an_edit_of_more_than_a_person_sets_is_refused_before_it_is_read(tmp_path: Path) -> None:
    session = load_session(cases.write_session(tmp_path))
    with pytest.raises(ValueError, match="more than the 10000"):
        apply_changes(session, {"keyframes": {"set": [{"not": "read"}] * 10_001}})
