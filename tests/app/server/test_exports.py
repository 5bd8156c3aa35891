"""Long exports of a real server: what it writes is what the command line writes."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.request import ProxyHandler, Request, build_opener

import pytest

from keypose.app.server import exports
from tests.app.serving import LONGEST_S, ROOT, Keypose, Visitor

SIZE = "160x90"
ORBIT = {"what": "film", "view": "orbit", "size": SIZE, "frames": "0-12", "fps": "10"}


class Desk:
    """A server with a session open, and its HTTP."""

    def __init__(self, folder: Path, sample: str = "box") -> None:
        place = folder / sample
        shutil.copytree(ROOT / "sample_videos" / sample, place)
        self.session = place / "session.json"
        self.keypose = Keypose(str(self.session), "--workspace", str(folder / "workspace"))

    def ask(self, path: str, method: str = "GET", order: Any = None) -> tuple[int, bytes]:
        headers = {**self.keypose.entered.headers, "Origin": self.keypose.origin}
        body = None if order is None else json.dumps(order).encode()
        request = Request(self.keypose.origin + path, body, headers, method=method)
        try:
            with build_opener(ProxyHandler({})).open(request, timeout=LONGEST_S) as answer:
                return answer.status, answer.read()
        except HTTPError as error:
            with error:
                return error.code, error.read()

    def begin(self, order: Any) -> str:
        status, content = self.ask("/exports", "POST", order)
        assert status == 200, content
        return str(json.loads(content)["id"])

    def refused(self, order: Any) -> str:
        status, content = self.ask("/exports", "POST", order)
        assert status in (400, 409)
        return str(json.loads(content)["words"])

    def state(self, id: str) -> dict[str, Any]:
        return dict(json.loads(self.ask(f"/exports/{id}")[1]))

    def until(self, id: str, there: Any) -> dict[str, Any]:
        end = time.monotonic() + LONGEST_S
        while not there(state := self.state(id)):
            assert time.monotonic() < end, state
            time.sleep(0.05)
        return state

    def exported(self, order: Any) -> bytes:
        id = self.begin(order)
        state = self.until(id, lambda state: state["state"] != "running")
        assert state["state"] == "done", state
        status, content = self.ask(f"/exports/{id}/file")
        assert status == 200
        return content

    def commanded(self, *arguments: str, out: Path) -> bytes:
        command = [sys.executable, "-m", "keypose.app", *arguments, "--out", str(out)]
        subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=LONGEST_S)
        return out.read_bytes() if out.is_file() else b""


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    made = Desk(tmp_path_factory.mktemp("exports"))
    yield made
    ended(made)


def ended(made: Desk) -> None:
    code, words = made.keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


def test_a_film_is_that_of_the_command_line(desk: Desk, tmp_path: Path) -> None:
    options = ("--view", "orbit", "--size", "160x90", "--frames", "0-12", "--fps", "10")
    killed = tmp_path / ".film.mp4.0123456789ab.part"
    killed.touch()
    os.utime(killed, (1.0, 1.0))
    film = desk.commanded("film", str(desk.session), *options, out=tmp_path / "film.mp4")
    assert desk.exported(ORBIT) == film
    assert not killed.exists()


def test_a_sheet_is_that_of_the_command_line(desk: Desk, tmp_path: Path) -> None:
    options = ("--style", "wire", "--columns", "1")
    sheet = desk.commanded("sheet", str(desk.session), *options, out=tmp_path / "sheet.png")
    assert desk.exported({"what": "sheet", "style": "wire", "columns": "1"}) == sheet


def test_pictures_are_those_of_the_command_line(desk: Desk, tmp_path: Path) -> None:
    order = {"what": "pictures", "view": "side", "background": "none", "size": SIZE}
    with zipfile.ZipFile(io.BytesIO(desk.exported(order))) as archive:
        assert archive.namelist() == ["frame0000.png", "frame0040.png"]
        last = archive.read("frame0040.png")
    options = ("--frame", "40", "--view", "side", "--background", "none", "--size", "160x90")
    assert last == desk.commanded("shot", str(desk.session), *options, out=tmp_path / "a.png")


def test_a_matte_is_that_of_the_command_line(tmp_path: Path) -> None:
    man = Desk(tmp_path, "balance")
    options = ("matte", str(man.session), "--frames", "15-16")
    order = {"what": "matte", "frames": "15-16"}
    man.commanded(*options, out=tmp_path / "out")
    with zipfile.ZipFile(io.BytesIO(man.exported(order))) as archive:
        assert archive.namelist() == ["frame0015.png", "frame0016.png"]
        for name in archive.namelist():
            assert archive.read(name) == (tmp_path / "out" / name).read_bytes()
    film = man.commanded(*options, "--kind", "mov", "--alpha-only", out=tmp_path / "a.mov")
    assert man.exported({**order, "kind": "mov", "alpha_only": "true"}) == film
    ended(man)


def test_a_long_export_shows_how_far_it_is_is_cancelled_and_leaves_the_page_quick(
    desk: Desk,
) -> None:
    long = {"what": "film", "view": "all", "size": "1280x720"}
    id = desk.begin(long)
    desk.until(id, lambda state: state["done"] >= 1 and state["of"] == 41)
    assert "Another export" in desk.refused(ORBIT)
    visitor = Visitor(desk.keypose)
    visitor.do(do="go", frame=3)
    visitor.leave()
    status, content = desk.ask(f"/exports/{id}", "DELETE")
    assert (status, json.loads(content)["state"]) == (200, "cancelled")
    assert desk.ask(f"/exports/{id}")[0] == 404
    assert desk.exported(ORBIT)


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ({"what": "film", "frames": "5-99"}, "no frame 99"),
        ({"what": "film", "frames": "5-2"}, "no frames such as 10-60"),
        ({"what": "film", "size": "9000x20"}, "Size"),
        ({"what": "film", "size": "8000x8000"}, "20 million"),
        ({"what": "film", "fps": "0"}, "Rate"),
        ({"what": "film", "out": "/etc/passwd"}, "out"),
        ({"what": "film", "tint": "contact"}, "no surface to colour"),
        ({"what": "pictures", "frames": "x"}, "Frames"),
        ({"what": "sheet", "columns": "0"}, "Columns"),
        ({"what": "matte", "kind": "gif"}, "Format"),
        ({"what": "matte", "frames": "5-99"}, "no frame 99"),
        ({"what": "everything"}, "no export 'everything'"),
        ("x" * 70000, "too long"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_words(desk: Desk, order: Any, words: str) -> None:
    assert words in desk.refused(order)


def test_what_is_not_installed_is_reported_with_what_mends_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert exports.missing_here() == {}
    monkeypatch.setattr(exports.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(exports, "can_write_films", lambda: False)
    assert exports.missing_here() == {
        "c3d": "pip install 'keypose[c3d]'",
        "usd": "pip install 'keypose[usd]'",
        "film": "pip install --force-reinstall av",
    }


def test_an_export_needs_the_key_and_our_own_page(desk: Desk) -> None:
    own = desk.keypose.entered
    for headers in (
        {"Cookie": own.cookie, "Origin": desk.keypose.origin},
        {**own.headers},
        {**own.headers, "Origin": "http://127.0.0.1:1"},
    ):
        request = Request(f"{desk.keypose.origin}/exports", b"{}", headers, method="POST")
        with pytest.raises(HTTPError, match="403") as refused:
            build_opener(ProxyHandler({})).open(request, timeout=LONGEST_S)
        refused.value.close()
    assert desk.ask("/exports/../../etc/passwd/file")[0] in (403, 404)
    assert desk.ask("/exports/0123456789abcdef/file")[0] == 404
