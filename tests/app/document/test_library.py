"""The library: what is listed, what is opened, what is never written or left."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path
from typing import TYPE_CHECKING, cast

import av
import cv2
import numpy as np
import pytest

from keypose.app.document.library import Library, thumbnails, usual_folders
from keypose.app.document.library.files import find_files
from keypose.app.document.library.names import clean_name
from keypose.app.document.library.recents import strip_of
from keypose.app.document.library.thumbnails import ThumbCache
from keypose.app.document.library.uploads import Upload
from keypose.app.document.open import open_for_editing
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.surface.source import holds_meshes
from keypose.tracker.video import Video
from tests.tracker import session_cases as cases

if TYPE_CHECKING:
    from av.video.stream import VideoStream

SAMPLES = Path(__file__).resolve().parents[3] / "sample_videos"
PART = "0123456789ab.part"


@pytest.fixture
def home(tmp_path: Path) -> Path:
    folder = tmp_path / "home"
    folder.mkdir()
    return folder


@pytest.fixture
def library(tmp_path: Path, home: Path) -> Library:
    return Library(tmp_path / "workspace", [home])


def clip(folder: Path, name: str = "jump.mp4") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(SAMPLES / "box" / "box.mp4", folder / name)
    return folder / name


def session_in(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return cases.write_session(folder)


def names(library: Library) -> list[str]:
    return [file["name"] for file in library.contents()["files"]]


def uploaded(library: Library, name: str, content: bytes = b"film") -> str:
    with library.upload(name, len(content)) as upload:
        upload.write(content)
        return upload.finish()


def left_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir()) if folder.exists() else []


# --- what is listed


@pytest.mark.parametrize(("images", "kind"), [(0, "meshes"), (10, "meshes"), (30, "images")])
def test_a_folder_is_listed_as_what_it_opens_as(
    library: Library, home: Path, images: int, kind: str
) -> None:
    folder = home / "scan"
    folder.mkdir()
    for number in range(3):
        (folder / f"{number}.ply").touch()
    for number in range(images):
        (folder / f"{number}.PNG").touch()
    (found,) = [file["kind"] for file in library.contents()["files"] if file["name"] == "scan"]
    assert found == kind
    assert holds_meshes(folder) == (kind == "meshes")


def test_videos_sessions_and_folders_of_images_are_listed(library: Library, home: Path) -> None:
    clip(home / "clips")
    session_in(home / "throw.keypose")
    for number in range(3):
        path = home / "shots" / f"{number}.png"
        path.parent.mkdir(exist_ok=True)
        cv2.imwrite(str(path), np.zeros((4, 4, 3), np.uint8))
    (home / "notes.txt").write_text("no")
    (home / "other.json").write_text("{}")
    found = {file["name"]: file["kind"] for file in library.contents()["files"]}
    assert found["jump.mp4"] == "video"
    assert found["throw"] == "session"
    assert found["shots"] == "images"
    assert not {"notes.txt", "other.json"} & set(found)


FILMS = {  # container and codec by the ending of the name
    ".ts": ("mpegts", "mpeg2video"),
    ".mts": ("mpegts", "h264"),
    ".m2ts": ("mpegts", "h264"),
    ".mpg": ("mpeg", "mpeg2video"),
    ".vob": ("vob", "mpeg2video"),
    ".flv": ("flv", "flv"),
    ".gif": ("gif", "gif"),
    ".wmv": ("asf", "wmv2"),
    ".3gp": ("3gp", "h264"),
    ".mjpeg": ("mjpeg", "mjpeg"),
}


def film(place: Path, container: str, codec: str, **options: str) -> Path:
    """Twelve grey frames: a transport stream is known by a number of packets."""
    formats = {"gif": "rgb8", "mjpeg": "yuvj420p"}
    with av.open(str(place), "w", format=container, options=options) as out:
        stream = cast("VideoStream", out.add_stream(codec, rate=25))
        stream.width, stream.height, stream.pix_fmt = 64, 48, formats.get(codec, "yuv420p")
        for grey in range(0, 240, 20):
            picture = np.full((48, 64, 3), grey, np.uint8)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        out.mux(stream.encode())
    return place


@pytest.mark.parametrize("ending", FILMS)
def test_films_of_every_kind_that_is_read_are_listed_and_taken(
    library: Library, home: Path, ending: str
) -> None:
    place = film(home / f"jump{ending}", *FILMS[ending])
    assert [(f["name"], f["kind"]) for f in library.contents()["files"]] == [(place.name, "video")]
    assert ending in library.contents()["suffixes"]
    name = uploaded(library, f"Jump{ending.upper()}", place.read_bytes())
    with Video.open(library.find("upload", name)) as video:
        assert video.info.frame_count == 12


def test_a_recorder_s_transport_stream_is_listed_and_code_of_that_ending_is_not(
    library: Library, home: Path
) -> None:
    film(home / "recorded.mts", "mpegts", "h264", mpegts_m2ts_mode="1")
    (home / "page.ts").write_text("Good code, not a film\n" * 100)
    os.mkfifo(home / "pipe.ts")
    assert [f["name"] for f in library.contents()["files"]] == ["recorded.mts"]


def test_what_was_set_aside_of_a_session_is_not_listed(library: Library, home: Path) -> None:
    path = session_in(home / "throw.keypose")
    shutil.copyfile(path, path.with_name("session.theirs-0123abcd.json"))
    shutil.copyfile(path, path.with_name("take2.json"))
    found = [file["name"] for file in library.contents()["files"] if file["kind"] == "session"]
    assert sorted(found) == ["take2.json", "throw"]


def test_films_in_the_usual_folders_of_a_home_are_listed(tmp_path: Path, home: Path) -> None:
    clip(home / "Videos", "dance.mp4")
    clip(home / "Letters", "private.mp4")
    folders = usual_folders(home)
    assert folders == [home / "Videos"]
    assert names(Library(tmp_path / "workspace", folders)) == ["dance.mp4"]


def test_hidden_folders_are_not_looked_into(library: Library, home: Path) -> None:
    clip(home / ".cache")
    clip(home, ".hidden.mp4")
    assert names(library) == []


def test_folders_that_tools_make_are_not_looked_into(library: Library, home: Path) -> None:
    for name in ("node_modules", "keypose.egg-info"):
        clip(home / name)
    clip(home / "films")
    assert names(library) == ["jump.mp4"]
    (root,) = library.folder("")["folders"]
    assert [place["name"] for place in library.folder(root["id"])["folders"]] == ["films"]


def test_a_link_out_of_the_folders_is_neither_listed_nor_opened(
    library: Library, home: Path, tmp_path: Path
) -> None:
    outside = clip(tmp_path / "outside")
    (home / "link.mp4").symlink_to(outside)
    (home / "linked").symlink_to(outside.parent)
    assert names(library) == []
    for id in ("0/link.mp4", "0/linked/jump.mp4"):
        with pytest.raises(KeyposeError, match="no longer exists"):
            library.find("file", id)


@pytest.mark.parametrize("id", [f"0/{'a' * 4000}", f"{'9' * 5000}/jump.mp4", f"0/{'a/' * 3000}"])
def test_an_id_longer_than_any_name_is_of_nothing(library: Library, id: str) -> None:
    with pytest.raises(KeyposeError, match=r"This file no longer exists\."):
        library.find("file", id)
    with pytest.raises(KeyposeError, match=r"This folder no longer exists\."):
        library.folder(id)
    assert library.file_thumb(id) is None


def test_a_link_to_a_file_inside_is_listed_once(library: Library, home: Path) -> None:
    (home / "z.mp4").symlink_to(clip(home))
    assert len(names(library)) == 1


def test_a_listed_file_is_found_by_its_id(library: Library, home: Path) -> None:
    video = clip(home / "ä #?%", "sprung 1.mp4")
    (file,) = library.contents()["files"]
    assert library.find("file", file["id"]) == video


@pytest.mark.parametrize(
    "id",
    [
        *("", "0", "0/", "0/nothing.mp4", "0/../outside/jump.mp4", "0/%2e%2e/outside/jump.mp4"),
        *("9/jump.mp4", "-1/jump.mp4", "0//etc/passwd", "0/a%00.mp4", "x/jump.mp4", "٣/jump.mp4"),
    ],
)
def test_an_id_leads_nowhere_else(id: str, library: Library, tmp_path: Path) -> None:
    clip(tmp_path / "outside")
    with pytest.raises(KeyposeError):
        library.find("file", id)


# --- one folder at a time


def test_folders_are_walked_from_the_roots_and_back(library: Library, home: Path) -> None:
    clip(home / "2026" / "May", "jump.mp4")
    session_in(home / "2026" / "throw.keypose")
    (home / "2026" / "notes.txt").touch()
    roots = library.folder("")
    assert roots["way"] == []
    (root,) = roots["folders"]
    (year,) = library.folder(root["id"])["folders"]
    listing = library.folder(year["id"])
    assert [place["name"] for place in listing["way"]] == ["home", "2026"]
    assert [place["name"] for place in listing["folders"]] == ["May"]
    assert [(f["name"], f["kind"]) for f in listing["files"]] == [("throw", "session")]
    (may,) = listing["folders"]
    (file,) = library.folder(may["id"])["files"]
    assert library.find("file", file["id"]) == home / "2026" / "May" / "jump.mp4"
    assert library.folder(listing["way"][0]["id"])["folders"] == [year]


def test_a_folder_of_images_or_meshes_is_told_apart(library: Library, home: Path) -> None:
    for folder, ending in (("shots", "png"), ("scan", "ply")):
        (home / folder).mkdir()
        for number in range(3):
            (home / folder / f"{number}.{ending}").touch()
    files = {f["name"]: (f["kind"], f["count"]) for f in library.folder("0/")["files"]}
    assert files == {"shots": ("images", 3), "scan": ("meshes", 3)}


@pytest.mark.parametrize(
    "id",
    [
        *("0", "0/..", "0/%2e%2e", "0/../outside", "0//etc", "/", "9/", "-1/", "x/", "٠/"),
        *("0/.hidden", "0/linked", "0/nothing", "0/jump.mp4", "0/a%00", "0/sub/../../outside"),
    ],
)
def test_walking_leads_nowhere_else(id: str, library: Library, home: Path, tmp_path: Path) -> None:
    clip(tmp_path / "outside")
    clip(home / ".hidden")
    clip(home)
    (home / "linked").symlink_to(tmp_path / "outside")
    with pytest.raises(KeyposeError, match="no longer exists"):
        library.folder(id)
    assert [place["name"] for place in library.folder("0/")["folders"]] == []
    assert id == "0" or library.file_thumb(f"{id}/jump.mp4") is None


def test_films_images_and_sessions_have_small_pictures_that_are_kept(
    library: Library, home: Path, tmp_path: Path
) -> None:
    video = clip(home)
    shutil.copytree(SAMPLES / "person", home / "walk")
    (home / "shots").mkdir()
    for number in range(2):
        cv2.imwrite(str(home / "shots" / f"{number}.png"), np.full((60, 90, 3), 200, np.uint8))
    for id in ("0/jump.mp4", "0/walk/session.json", "0/shots"):
        content = library.file_thumb(id)
        assert content is not None
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None
        assert picture.shape == (112, 192, 3)
        assert len(content) < 20_000
    kept = left_in(tmp_path / "workspace" / "thumbs")
    assert len(kept) == 3
    video.write_bytes(video.read_bytes() + b"x")  # another file has another picture
    library.file_thumb("0/jump.mp4")
    assert len(left_in(tmp_path / "workspace" / "thumbs")) == 4


def test_small_pictures_beyond_so_many_go_the_oldest_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(thumbnails, "MOST", 2)
    cache = ThumbCache(tmp_path)
    for age, name in enumerate(("a", "file-b", "c")):
        cache.get(name, lambda: b"picture")
        os.utime(tmp_path / f"{name}.jpg", (10.0**9 + age, 10.0**9 + age))
    cache.get("d", lambda: b"picture")
    assert left_in(tmp_path) == ["c.jpg", "d.jpg"]


def test_what_is_no_film_has_no_picture(library: Library, home: Path) -> None:
    (home / "broken.mp4").write_bytes(b"no film")
    cv2.imwrite(str(home / "private.png"), np.zeros((4, 4, 3), np.uint8))
    clip(home, ".hidden.mp4")
    for id in ("0/broken.mp4", "0/private.png", "0/.hidden.mp4", "0/", "", "0/none.mp4"):
        assert library.file_thumb(id) is None


def test_a_name_that_is_no_text_is_listed_and_found(library: Library, home: Path) -> None:
    strange = Path(os.fsdecode(os.fsencode(home) + b"/film\xff.mp4"))
    shutil.copyfile(SAMPLES / "box" / "box.mp4", strange)
    (file,) = library.contents()["files"]
    file["name"].encode()
    assert library.find("file", file["id"]) == strange


def test_a_listing_that_would_never_end_ends(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("keypose.app.document.library.files.MOST_ENTRIES", 5)
    for number in range(9):
        (home / f"{number}.txt").touch()
    assert find_files([home]).more


def test_a_pipe_named_like_a_session_does_not_hang(library: Library, home: Path) -> None:
    os.mkfifo(home / "session.json")
    assert names(library) == []


# --- recent sessions


def test_a_remembered_session_is_shown_with_its_facts(library: Library, home: Path) -> None:
    path = session_in(home / "throw.keypose")
    library.remember(path, load_session(path), [(0, 4, "good"), (4, 8, "lost")])
    (recent,) = library.contents()["recents"]
    assert recent["name"] == "throw"
    assert (recent["keyframes"], recent["frames"]) == (3, 9)
    assert recent["strip"] == [["good", 4], ["lost", 4]]
    assert not recent["missing"]
    assert library.find("recent", recent["id"]) == path


def test_a_film_that_was_opened_and_not_touched_is_listed_and_opens_again(
    tmp_path: Path, home: Path
) -> None:
    video = clip(home, "jump.mp4")
    workspace = tmp_path / "place"
    library = Library(workspace, [home])
    opened = open_for_editing(video, library.session_for)
    opened.video.close()
    library.visit(opened.session_path, video, opened.session)
    again = Library(workspace, [home])  # as after a restart
    (recent,) = again.contents()["recents"]
    assert (recent["name"], recent["keyframes"]) == ("jump", 0)
    assert not recent["missing"]  # although no folder of its own is there yet
    assert again.find("recent", recent["id"]) == video
    assert again.thumb(recent["thumb"].removeprefix("/thumb/").removesuffix(".jpg")) is not None
    for change in (again.duplicate, again.delete, lambda id: again.rename(id, "x")):
        with pytest.raises(KeyposeError, match="Nothing of this session is saved yet"):
            change(recent["id"])
    assert video.is_file()
    video.unlink()
    assert again.recents() == []


def test_once_it_is_saved_such_a_film_leads_to_its_session(tmp_path: Path, home: Path) -> None:
    video = clip(home, "jump.mp4")
    library = Library(tmp_path / "place", [home])
    opened = open_for_editing(video, library.session_for)
    opened.video.close()
    library.visit(opened.session_path, video, opened.session)
    opened.session_path.parent.mkdir()
    save_session(opened.session, opened.session_path)
    library.remember(opened.session_path, opened.session)
    (recent,) = library.recents()
    assert library.find("recent", recent.id) == opened.session_path


def test_the_newest_is_first_and_none_is_shown_twice(library: Library, home: Path) -> None:
    one, other = session_in(home / "one"), session_in(home / "other")
    for path in (one, other, one):
        library.remember(path, load_session(path))
    assert [recent.name for recent in library.recents()] == ["one", "other"]


def test_verdicts_come_from_the_session_when_none_are_given(tracked_path: Path) -> None:
    library = Library(tracked_path.parent / "workspace")
    library.remember(tracked_path, load_session(tracked_path))
    (recent,) = library.recents()
    assert {state for state, _ in recent.strip} <= {"good", "check", "lost"}


def test_a_moved_video_is_reported(library: Library, home: Path) -> None:
    path = session_in(home / "throw")
    session = load_session(path)
    library.remember(path, session)
    (path.parent / session.view.video.path).rename(home / "elsewhere")
    (recent,) = library.contents()["recents"]
    assert recent["missing"]


def test_another_video_in_the_place_of_the_sessions_own_is_reported(
    library: Library, home: Path
) -> None:
    film, other = clip(home / "throw"), SAMPLES / "person" / "person.mp4"
    shutil.copyfile(SAMPLES / "box" / "session.json", film.parent / "session.json")
    film.rename(film.with_name("box.mp4"))
    path = film.parent / "session.json"
    library.remember(path, load_session(path))
    assert not library.contents()["recents"][0]["exchanged"]
    shutil.copyfile(other, film.with_name("box.mp4"))
    (recent,) = library.contents()["recents"]
    assert recent["missing"]
    assert recent["exchanged"]


def test_a_moved_video_is_found_again(library: Library, home: Path) -> None:
    path = session_in(home / "throw")
    session = load_session(path)
    library.remember(path, session)
    (path.parent / session.view.video.path).rename(home / "elsewhere")
    id = library.recents()[0].id
    assert library.find("recent", id, video="0/elsewhere") == path
    open_video_of(load_session(path), path).close()


def test_another_video_is_not_taken_for_the_moved_one(library: Library, home: Path) -> None:
    path = session_in(home / "throw")
    before = path.read_bytes()
    library.remember(path, load_session(path))
    clip(home)
    with pytest.raises(SessionError, match="another video"):
        library.find("recent", library.recents()[0].id, video="0/jump.mp4")
    assert path.read_bytes() == before


def test_a_session_that_is_gone_is_not_shown(library: Library, home: Path) -> None:
    path = session_in(home / "throw")
    library.remember(path, load_session(path))
    id = library.recents()[0].id
    path.unlink()
    assert library.recents() == []
    with pytest.raises(KeyposeError, match="no longer exists"):
        library.find("recent", id)


def test_a_forgotten_session_keeps_its_files(library: Library, home: Path) -> None:
    path = session_in(home / "throw")
    library.remember(path, load_session(path))
    library.forget(library.recents()[0].id)
    assert library.recents() == []
    assert path.exists()


@pytest.mark.parametrize("content", [b"", b"\xff", b"[]", b'{"recents": [{"path": 1}]}'])
def test_a_spoilt_list_of_recents_is_as_good_as_none(library: Library, content: bytes) -> None:
    library.workspace.mkdir()
    (library.workspace / "recents.json").write_bytes(content)
    assert library.contents()["recents"] == []


def test_a_strip_covers_the_whole_video() -> None:
    strip = strip_of([(10, 20, "good"), (20, 30, "good"), (40, 50, "lost")], 100)
    assert strip == (("none", 10), ("good", 20), ("none", 10), ("lost", 10), ("none", 49))
    assert sum(frames for _, frames in strip) == 99
    assert strip_of([], 1) == ()


# --- where sessions live


def test_a_session_lives_beside_its_video(library: Library, home: Path) -> None:
    video = clip(home)
    assert library.session_for(video) == home / "jump.keypose" / "session.json"
    assert left_in(home) == ["jump.mp4"]


def test_a_session_lives_in_the_workspace_when_the_folder_is_locked(
    library: Library, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "keypose.app.document.library.session_files._is_writable", lambda folder: False
    )
    place = library.workspace / "jump.keypose" / "session.json"
    assert library.session_for(clip(home)) == place


def test_another_videos_session_is_left_alone(library: Library, home: Path) -> None:
    sample = SAMPLES / "box"
    taken = home / "box.keypose"
    taken.mkdir()
    shutil.copyfile(sample / "session.json", taken / "session.json")
    shutil.copyfile(sample / "box.mp4", taken / "box.mp4")
    video = clip(home, "box.mov")
    assert library.session_for(video) == home / "box 2.keypose" / "session.json"


def test_the_session_of_a_video_is_found_again(library: Library, home: Path) -> None:
    video = clip(home, "box.mp4")
    place = library.session_for(video)
    place.parent.mkdir()
    session = load_session(SAMPLES / "box" / "session.json")
    reference = session.view.video.model_copy(update={"path": "../box.mp4"})
    save_session(session.changed({"video": reference}), place)
    assert library.session_for(video) == place


def test_a_sample_is_opened_as_a_copy_that_is_kept(library: Library) -> None:
    path = library.find("sample", "balance")
    assert path == library.workspace / "balance" / "session.json"
    with open_video_of(load_session(path), path) as video:
        assert video.info.frame_count == 61
    assert (path.parent / "LICENSE").is_file()
    path.write_text("changed")
    assert library.find("sample", "balance").read_text() == "changed"
    assert left_in(library.workspace) == ["balance"]


@pytest.mark.parametrize("id", ["", "..", "bodies", "../balance", "balance/"])
def test_only_the_samples_are_samples(library: Library, id: str) -> None:
    with pytest.raises(KeyposeError):
        library.find("sample", id)


def test_the_words_of_the_samples_are_true(library: Library) -> None:
    for sample in library.contents()["samples"]:
        session = load_session(SAMPLES / sample["id"] / "session.json")
        assert f"{session.view.video.frame_count} frames" in sample["words"]
        assert f"{len(session.subject.keyframes)} keyframe" in sample["words"]


# --- uploads


def test_an_upload_is_whole_under_its_name(library: Library) -> None:
    id = uploaded(library, "jump.mp4")
    assert library.find("upload", id) == library.uploads / "jump.mp4"
    assert library.find("upload", id).read_bytes() == b"film"
    assert names(library) == ["jump.mp4"]


def test_an_upload_that_is_no_video_is_discarded(library: Library) -> None:
    library.discard(uploaded(library, "jump.mp4"))
    library.discard("jump.mp4")
    assert left_in(library.uploads) == []


def test_the_same_name_is_never_overwritten(library: Library) -> None:
    ids = [uploaded(library, "jump.mp4", content) for content in (b"1", b"22", b"333")]
    assert ids == ["jump.mp4", "jump 2.mp4", "jump 3.mp4"]
    assert (library.uploads / "jump.mp4").read_bytes() == b"1"


def test_an_upload_that_breaks_off_leaves_nothing(library: Library) -> None:
    with library.upload("jump.mp4", 8) as upload:
        upload.write(b"half")
    assert left_in(library.uploads) == []


def test_an_upload_that_is_too_short_is_refused(library: Library) -> None:
    upload = library.upload("jump.mp4", 8)
    upload.write(b"half")
    with pytest.raises(KeyposeError, match="not copied completely"):
        upload.finish()
    assert left_in(library.uploads) == []


def test_an_upload_that_is_longer_than_it_says_is_refused(library: Library) -> None:
    with pytest.raises(KeyposeError, match="larger"), library.upload("jump.mp4", 3) as upload:
        upload.write(b"four")
    assert left_in(library.uploads) == []


def test_an_upload_past_the_limit_is_refused_before_it_begins(tmp_path: Path) -> None:
    with pytest.raises(KeyposeError, match="too large"):
        Upload(tmp_path / "videos", "jump.mp4", 11, largest_bytes=10)
    assert left_in(tmp_path) == []


def test_an_upload_of_unknown_size_is_stopped_at_the_limit(tmp_path: Path) -> None:
    upload = Upload(tmp_path, "jump.mp4", None, largest_bytes=10)
    upload.write(bytes(10))
    with pytest.raises(KeyposeError, match="larger"):
        upload.write(b"1")
    assert left_in(tmp_path) == []


def test_an_upload_without_room_is_refused(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "keypose.app.document.library.uploads.free_bytes", lambda folder: 300 * 2**20
    )
    with pytest.raises(KeyposeError, match="no room"):
        library.upload("jump.mp4", 200 * 2**20)


def test_what_is_no_video_is_refused(library: Library) -> None:
    for name in ("notes.txt", "session.json", "", "mp4", "jump.mp4.exe"):
        with pytest.raises(KeyposeError, match="is not a video"):
            library.upload(name, 4)
    assert left_in(library.uploads) == []


def test_what_a_killed_program_left_is_swept_and_what_is_at_work_is_not(library: Library) -> None:
    library.uploads.mkdir(parents=True)
    old, young = library.uploads / f".a.mp4.{PART}", library.uploads / f".b.mp4.{PART}"
    for file in (old, young):
        file.write_bytes(b"half")
    os.utime(old, (time.time() - 2 * 24 * 3600,) * 2)
    uploaded(library, "jump.mp4")
    assert left_in(library.uploads) == [young.name, "jump.mp4"]


@pytest.mark.parametrize("id", ["", ".", "..", "../recents.json", "/etc/passwd", "a\0b", "x/y.mp4"])
def test_an_uploads_id_leads_to_uploads_alone(library: Library, id: str) -> None:
    uploaded(library, "jump.mp4")
    (library.workspace / "recents.json").touch()
    with pytest.raises(KeyposeError, match="no longer exists"):
        library.find("upload", id)


@pytest.mark.parametrize(
    ("given", "clean"),
    [
        ("jump.mp4", "jump.mp4"),
        ("../../etc/jump.mp4", "jump.mp4"),
        ("C:\\films\\jump.mp4", "jump.mp4"),
        ("a\0b\n\x1bc.mp4", "abc.mp4"),
        ("\u202e4pm.exe.mp4", "4pm.exe.mp4"),
        ("con.mp4", "_con.mp4"),
        ("LPT1.tar.mp4", "_LPT1.tar.mp4"),
        ('a<b>:"|?*.mp4', "a_b______.mp4"),
        (".hidden.mp4", "hidden.mp4"),
        ("jump.mp4. . ", "jump.mp4"),
        ("a\ud800b.mp4", "ab.mp4"),
        ("Sprünge – Ⅱ 跳.mp4", "Sprünge – Ⅱ 跳.mp4"),
        ("Spru\u0308nge.mp4", "Sprünge.mp4"),
        ("../..", "video"),
        ("", "video"),
    ],
)
def test_names_are_cleaned(given: str, clean: str) -> None:
    assert clean_name(given) == clean


def test_a_name_longer_than_any_file_is_cut_and_keeps_its_ending() -> None:
    name = clean_name("跳" * 300 + ".mp4")
    assert len(name.encode()) <= 120
    assert name.endswith("跳.mp4")


# --- pictures


def test_a_recent_session_has_a_small_picture(library: Library) -> None:
    path = library.find("sample", "balance")
    library.remember(path, load_session(path))
    (recent,) = library.contents()["recents"]
    id = recent["thumb"].removeprefix("/thumb/").removesuffix(".jpg")
    content = library.thumb(id)
    assert content is not None
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (112, 192, 3)
    assert library.thumb(id) == content


def test_every_sample_has_a_small_picture(library: Library) -> None:
    for sample in library.contents()["samples"]:
        assert library.thumb(sample["thumb"].removeprefix("/thumb/").removesuffix(".jpg"))


@pytest.mark.parametrize("id", ["", "..", "../recents", "sample-../x", "0123456789abcdef-4"])
def test_a_picture_of_nothing_known_is_none(library: Library, id: str) -> None:
    assert library.thumb(id) is None


def test_a_session_whose_video_is_gone_has_no_picture(library: Library, home: Path) -> None:
    path = session_in(home / "throw")
    session = load_session(path)
    library.remember(path, session)
    (path.parent / session.view.video.path).rename(home / "gone")
    (recent,) = library.contents()["recents"]
    assert library.thumb(recent["thumb"].removeprefix("/thumb/").removesuffix(".jpg")) is None
