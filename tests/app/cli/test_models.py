"""`keypose models`: which networks there are, and adding one."""

from __future__ import annotations

import hashlib
import io
import json
import tarfile
from dataclasses import replace
from pathlib import Path
from urllib.error import URLError

import pytest

from keypose.app.cli import models as command
from keypose.app.cli.main import main
from keypose.tracker.keypoints import model_files

CONTENT = b"stands for the large network"


@pytest.fixture(autouse=True)
def added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the large network will lie; here it is a small file with a digest of its own."""
    digest = hashlib.sha256(CONTENT).hexdigest()
    models = (model_files.FULL, replace(model_files.HEAVY, sha256=digest))
    monkeypatch.setattr(model_files, "MODELS", models)
    monkeypatch.setattr(command, "MODELS", models)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "keypose" / "models" / model_files.HEAVY.file


def packed(name: str = f"package/{model_files.HEAVY.file}", content: bytes = CONTENT) -> bytes:
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz") as package:
        for each, inside in (("package/package.json", b"{}"), (name, content)):
            entry = tarfile.TarInfo(each)
            entry.size = len(inside)
            package.addfile(entry, io.BytesIO(inside))
    return buffer.getvalue()


def run(*arguments: object) -> int:
    return main(["models", *map(str, arguments)])


def test_it_lists_what_is_here_and_how_to_get_the_rest(capsys: pytest.CaptureFixture[str]) -> None:
    assert run() == 0
    full, heavy = capsys.readouterr().out.splitlines()
    assert full.endswith("pose_landmark_full.tflite")
    assert heavy.endswith("keypose models add heavy")
    assert run("--json") == 0
    listed = json.loads(capsys.readouterr().out)["models"]
    assert [(model["name"], model["here"]) for model in listed] == [
        ("full", True),
        ("heavy", False),
    ]


@pytest.mark.parametrize("content", [CONTENT, packed()], ids=["file", "package"])
def test_a_network_is_added_from_a_file(tmp_path: Path, added: Path, content: bytes) -> None:
    file = tmp_path / "given"
    file.write_bytes(content)
    assert run("add", "heavy", "--from", file) == 0
    assert added.read_bytes() == CONTENT


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (CONTENT[:-1], "is damaged or is not the heavy network"),
        (packed(content=b"other"), "is damaged or is not the heavy network"),
        (packed(name="package/other.tflite"), "holds no pose_landmark_heavy.tflite"),
        (packed()[:40], "cannot be unpacked"),
        (b"\x1f\x8bnothing", "cannot be unpacked"),
    ],
    ids=["truncated", "other content", "other package", "truncated package", "no package"],
)
def test_any_other_file_is_refused_and_nothing_is_written(
    tmp_path: Path,
    added: Path,
    capsys: pytest.CaptureFixture[str],
    content: bytes,
    words: str,
) -> None:
    file = tmp_path / "given"
    file.write_bytes(content)
    assert run("add", "heavy", "--from", file) == 2
    assert words in capsys.readouterr().err
    assert not added.parent.exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("add",), "Name the network to add"),
        (("add", "huge"), "choose from full and heavy"),
        (("add", "full"), "comes with Keypose"),
        (("--from", "a"), "--from belongs to"),
        (("add", "heavy", "--from", "nowhere"), "cannot be read"),
    ],
)
def test_wrong_arguments_are_reported_in_one_sentence(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], words: str
) -> None:
    assert run(*arguments) == 2
    assert words in capsys.readouterr().err


def test_a_network_is_downloaded(added: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "urlopen", lambda url, timeout: io.BytesIO(packed()))
    assert run("add", "heavy") == 0
    assert added.read_bytes() == CONTENT


def test_without_a_network_it_says_how_to_use_a_file(
    added: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def offline(url: str, timeout: float) -> None:
        raise URLError("Name or service not known")

    monkeypatch.setattr(command, "urlopen", offline)
    assert run("add", "heavy") == 2
    err = capsys.readouterr().err
    assert "Name or service not known" in err
    assert "keypose models add heavy --from FILE" in err
    assert not added.exists()
