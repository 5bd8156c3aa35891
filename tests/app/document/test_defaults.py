"""A person's defaults: what the file may say, and that it counts for new sessions only."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from keypose.app.cli.main import main
from keypose.app.document.defaults import Defaults, defaults_path, read_defaults
from keypose.app.document.library.library import SAMPLE_FOLDER
from keypose.app.document.new import new_session
from keypose.tracker.errors import KeyposeError
from keypose.tracker.video import Video


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "config.toml"
    monkeypatch.setenv("KEYPOSE_CONFIG", str(path))
    return path


def test_without_a_file_everything_is_as_built_in(config: Path) -> None:
    assert not config.exists()
    assert read_defaults() == Defaults()
    assert read_defaults().workspace == Path("~/Keypose").expanduser()


def test_the_file_lies_where_the_platform_keeps_settings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("KEYPOSE_CONFIG")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    path = defaults_path()
    assert path.name == "config.toml"
    assert path.parent.name == "keypose"


def test_a_new_session_begins_with_the_defaults(config: Path, tmp_path: Path) -> None:
    with Video.open(SAMPLE_FOLDER / "box" / "box.mp4") as video:
        usual = new_session(video, tmp_path / "session.json")
        config.write_text(
            'body = "elderly_female"\nmethod = "paper"\nsmooth = false\nnetwork = "mine"\n'
        )
        own = new_session(video, tmp_path / "session.json")
    assert (usual.subject.body.name, usual.settings.method, usual.settings.smooth) == (
        "adult_male",
        "keypose",
        True,
    )
    assert (own.subject.body.name, own.settings.method, own.settings.smooth) == (
        "elderly_female",
        "paper",
        False,
    )
    assert own.settings.cues == usual.settings.cues
    assert (usual.settings.network, own.settings.network) == ("thunder", "mine")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("port = 99999", "port: input should be less than or equal to 65535"),
        ('quality = "best"', "quality: input should be 'full' or 'preview'"),
        ('cues = ["silhouette"]', "cues: silhouette finds no motion alone"),
        ('network = "My own"', "network: a network's name has 1 to 32 lower-case letters, "),
        ('body = "cat"', "body: there is no body 'cat'; choose from adult_male, "),
        ('workspace = "films"', "workspace: write the whole path, or one that begins with ~"),
        ("colour = 1", "there is no setting 'colour'; the settings are workspace, port, "),
        ("port = ", "is not TOML: "),
        (f"port = {'9' * 5000}", "is not TOML: "),
        ("\0", "is not TOML: "),
    ],
)
def test_a_file_that_says_what_cannot_be_is_refused_in_one_sentence(
    config: Path, text: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    config.write_text(text)
    with pytest.raises(KeyposeError):
        read_defaults()
    assert main(["config"]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert str(config) in message
    assert message.count("\n") == 1


def test_a_quality_that_is_no_more_means_the_one_that_is_left(config: Path) -> None:
    config.write_text('quality = "fast"\n')
    assert read_defaults().quality == "full"


def test_what_config_prints_is_a_file_that_says_the_same(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config.write_text('quality = "preview"\nport = 8123\n')
    assert main(["config"]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith(f"# {config}\n")
    assert Defaults.model_validate(tomllib.loads(printed)) == read_defaults()
    assert "(built in)" not in next(line for line in printed.splitlines() if "port" in line)
    assert main(["config", "--json"]) == 0
    message = json.loads(capsys.readouterr().out)
    assert (message["path"], message["from_file"]) == (str(config), ["port", "quality"])
    assert message["values"]["port"] == 8123
