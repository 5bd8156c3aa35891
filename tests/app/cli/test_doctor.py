"""`keypose doctor`: what it says of a computer that is well, and of one that is not."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from keypose.app.cli import doctor
from keypose.app.cli.doctor import Finding, compiled_loops, examine, films, folders, networks, port
from keypose.app.cli.main import main
from keypose.app.server.addresses import bind
from keypose.tracker.keypoints import model_files
from keypose.tracker.video import encode
from tests.app.full_disks import mounted


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "config.toml"
    monkeypatch.setenv("KEYPOSE_CONFIG", str(path))
    return path


def test_a_computer_that_is_well_is_said_to_be(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", "--workspace", str(tmp_path)]) == 0
    text = capsys.readouterr().out
    assert "H.264 is written and read" in text
    assert str(tmp_path) in text
    assert text.splitlines()[-1].startswith("Keypose works here")


def test_every_finding_that_is_not_well_but_loops_to_compile_comes_with_a_remedy(
    tmp_path: Path,
) -> None:
    for finding in examine(tmp_path):
        if finding.state in ("warning", "error"):
            assert finding.remedy, finding


def test_what_cannot_be_written_to_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    found = {finding.name: finding for finding in folders(tmp_path / "file" / "workspace")}
    assert found["workspace"].state == "error"
    assert "cannot be written to" in found["workspace"].words


def test_a_full_cache_is_a_warning_that_says_where_room_is_needed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with mounted(tmp_path / "cache", "100k"):
        found = {finding.name: finding for finding in folders(tmp_path)}
    assert found["cache"].state == "warning"
    assert found["cache"].words.endswith("cannot be written to: No space left on device")


def test_the_exit_code_shows_that_something_is_wrong(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken() -> Iterator[Finding]:
        raise ZeroDivisionError("no films")
        yield

    monkeypatch.setattr(doctor, "films", broken)
    assert main(["doctor", "--json"]) == 1
    message = json.loads(capsys.readouterr().out)
    assert not message["well"]
    (wrong,) = [finding for finding in message["findings"] if finding["state"] == "error"]
    assert wrong["words"] == "cannot be checked: ZeroDivisionError: no films"


def test_defaults_that_cannot_be_are_found(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config.write_text("port = -1")
    assert main(["doctor"]) == 1
    assert f"{config}: port: " in capsys.readouterr().out


def test_without_an_encoder_films_are_limited_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(encode, "can_write_films", lambda: False)
    (found,) = films()
    assert (found.state, found.remedy) == ("warning", doctor.REINSTALL)


def test_a_damaged_network_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / model_files.FULL.file).write_bytes(b"not a network")
    monkeypatch.setattr(model_files, "__file__", str(tmp_path / "model_files.py"))
    monkeypatch.setattr(doctor, "networks", networks)
    found = [finding for finding in examine(tmp_path) if finding.name == "networks"]
    assert [finding.state for finding in found] == ["error"]
    assert "is damaged" in found[0].words


def test_each_library_that_runs_networks_fast_is_told_once() -> None:
    names = [finding.name for check in (networks, doctor.extras) for finding in check()]
    assert [names.count(n) for n in ("keypoints", "ai-edge-litert", "onnxruntime")] == [1, 1, 1]


def test_an_optional_part_comes_with_the_command_of_this_kind_of_installation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(doctor, "EXTRAS", (("no_such_module", "nothing", "nothing at all"),))
    (found,) = doctor.extras()
    assert found.remedy.endswith(" -m pip install nothing")
    monkeypatch.setattr(doctor.sys, "prefix", str(tmp_path))
    (tmp_path / "pipx_metadata.json").touch()
    (found,) = doctor.extras()
    assert (found.state, found.remedy) == ("note", "pipx inject keypose nothing")


def test_a_port_that_is_taken_is_noted(config: Path) -> None:
    taken = bind("127.0.0.1", 0)
    config.write_text(f"port = {taken.getsockname()[1]}")
    (found,) = port()
    taken.close()
    assert found.state == "note"
    (found,) = port()
    assert found.state == "ok"


def test_older_compiled_loops_are_named_with_their_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    older = tmp_path / "keypose" / "kernels" / "cpython-311-0.1"
    older.mkdir(parents=True)
    (older / "loop.nbc").write_bytes(bytes(2_000_000))
    assert any("1 of other versions take 2 MB" in finding.words for finding in compiled_loops())
