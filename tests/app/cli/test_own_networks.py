"""A network of a person's own: trusted by its digest, told apart, used, and removed."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
import shutil
import subprocess
import zipfile
from contextlib import nullcontext
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints import model_files, recognise_network, runtimes
from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.model_files import (
    FULL,
    THUNDER,
    Model,
    added_folder,
    find_model,
    is_content,
)
from keypose.tracker.keypoints.region import Region
from keypose.tracker.operations.track import tracker_of
from keypose.tracker.scratch import Scratch
from keypose.tracker.session.settings import ALL_CUES
from keypose.tracker.storage import networks
from keypose.tracker.storage.files import load_session, save_session
from tests.tracker.keypoints import tiny_networks as tiny
from tests.tracker.keypoints.keypoint_cases import BALANCE, BOX

SIMCC = tiny.simcc()
AROUND = ",".join(f"{value:g}" for value in BOX)


@pytest.fixture(autouse=True)
def _alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def run(*arguments: object) -> int:
    return main([str(argument) for argument in arguments])


def add(folder: Path, content: bytes, *, name: str = "mine", sha256: str | None = None) -> int:
    file = folder / "given"
    file.write_bytes(content)
    digest = hashlib.sha256(content).hexdigest() if sha256 is None else sha256
    return run("models", "add", name, "--from", file, *(("--sha256", digest) if digest else ()))


def zipped(*entries: tuple[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return buffer.getvalue()


def test_it_is_added_listed_drafted_with_tracked_with_and_removed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = THUNDER.path.read_bytes()
    assert add(tmp_path, content) == 0
    assert run("models") == 0
    line = capsys.readouterr().out.splitlines()[-1]
    assert line.startswith("mine")
    assert line.endswith("MoveNet, 17 joints, 256 × 256")
    assert run("models", "--json") == 0
    facts = json.loads(capsys.readouterr().out)["models"][-1]
    assert (facts["name"], facts["sha256"]) == ("mine", hashlib.sha256(content).hexdigest())
    assert (facts["kind"], facts["layout"], facts["here"]) == ("movenet", "COCO_17", True)

    drafted = tmp_path / "drafted"
    video, which = BALANCE / "balance.mp4", ("--frames", "0-2", "--network", "mine")
    assert run("draft", video, "--box", AROUND, *which, "--out", drafted) == 0
    assert load_session(drafted / "session.json").settings.network == "mine"

    shutil.copytree(BALANCE, tmp_path / "balance")
    path = tmp_path / "balance" / "session.json"
    session = load_session(path)
    save_session(session.changed({"keyframes": session.subject.keyframes[:2]}), path)
    asked = ("--network", "mine", "--cues", "brightness,keypoints", "--quality", "preview")
    assert run("track", path, *asked) in (0, 1)
    assert load_session(path).subject.results is not None

    assert run("models", "remove", "mine") == 0
    assert list(added_folder().iterdir()) == []
    capsys.readouterr()
    draft = ("draft", video, "--box", AROUND, *which, "--out", tmp_path / "again")
    for command in (("track", path, *asked), draft):
        assert run(*command) == 2
        assert "keypose models add mine --from FILE --sha256 DIGEST" in capsys.readouterr().err
    assert not (tmp_path / "again").exists()


def test_the_published_method_needs_no_network() -> None:
    session, video = load_session(BALANCE / "session.json"), cast("Any", None)
    of = {"network": "mine", "cues": ALL_CUES, "static_camera": False}
    for method, refused in (("paper", False), ("keypose", True)):
        settings = session.settings.model_copy(update={**of, "method": method})
        with pytest.raises(KeypointError, match="no network 'mine'") if refused else nullcontext():
            tracker_of(session.changed({"settings": settings}), video)


@pytest.mark.parametrize("bundled", [THUNDER, FULL])
def test_a_network_that_came_with_keypose_and_is_gone_comes_with_it_again(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    bundled: Model,
) -> None:
    monkeypatch.setattr(model_files, "__file__", str(tmp_path / "model_files.py"))
    assert run("models") == 0
    (line,) = (x for x in capsys.readouterr().out.splitlines() if x.startswith(bundled.name))
    again = "pip install --force-reinstall keypose"
    assert line.endswith(f"not here: {again}")
    with pytest.raises(KeypointError, match=f"is not installed: run `{again}`"):
        model_files.verified(bundled)


@pytest.mark.parametrize("folder", ["", "rtmpose-m/", "./20230728/model/"])
def test_a_zip_of_mmdeploy_is_read(tmp_path: Path, folder: str) -> None:
    content = zipped((f"{folder}pipeline.json", b"{}"), (f"{folder}end2end.onnx", SIMCC))
    assert add(tmp_path, content) == 0
    model = find_model("mine")
    assert model.path.read_bytes() == SIMCC
    assert model.sha256 == hashlib.sha256(SIMCC).hexdigest()


def test_a_file_is_not_looked_into_before_it_is_trusted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(networks, "recognised")
    digest = hashlib.sha256(SIMCC).hexdigest()
    wrong = f"is another file or damaged: its SHA-256 is {digest}, not the one given."
    asked = f"is {digest}; add it with --sha256 {digest} if you trust"
    for given, words in (("", asked), ("0" * 64, wrong)):
        assert add(tmp_path, SIMCC, sha256=given) == 2
        assert words in capsys.readouterr().err
    assert not added_folder().exists()


def _image(width: int = 192, height: int = 256) -> dict[str, tuple[int | str, ...]]:
    return {"input": (1, 3, height, width)}


def _pooled(name: str) -> bytes:
    return tiny.node("ReduceMax", ["input"], name, axes=[3], keepdims=0)


ONE = {"a": (1, 3, 256)}
WRONG: dict[str, tuple[bytes, str]] = {
    "text": (b"# a network", "is no ONNX file, or not all of one"),
    "nothing": (b"", "has the input nothing and the output nothing: read are MoveNet (heat, "),
    "cut short": (SIMCC[: len(SIMCC) // 2], "is no ONNX file, or not all of one: it ends early."),
    "another network": (
        tiny.model([_pooled("a")], {}, _image(), ONE),
        "has the input 'input' (1 × 3 × 256 × 192) and the output 'a' (1 × 3 × 256): read are",
    ),
    "other outputs": (
        tiny.model([_pooled("a"), _pooled("b")], {}, _image(), {**ONE, "b": (1, 3, 256)}),
        "'b' (1 × 3 × 256): read are MoveNet (heat, reg, center and off), RTMPose and RTMW",
    ),
    "two inputs": (
        tiny.model([_pooled("a")], {}, {**_image(), "mask": (1, 1)}, ONE),
        "'mask' (1 × 1)",
    ),
    "maps of another size": (tiny.maps(cells=2), "(1 × 17 × 128 × 96): read are"),
    "an operation that there is not": (
        tiny.model([tiny.node("Nonsense", ["input"], "a")], {}, _image(), ONE),
        "The network 'mine.onnx' cannot be run by ",
    ),
    "operations that do not fit": (
        tiny.model([tiny.node("MatMul", ["input", "input"], "a")], {}, _image(), ONE),
        "' cannot be run by ",
    ),
    "a giant input": (tiny.model([_pooled("a")], {}, _image(99999, 99999), ONE), "read are"),
    "a hand": (tiny.simcc(21), "is a network of a hand alone: only those of a whole person"),
    "a face": (tiny.maps(68), "is a network of 68 joints: only those of a whole person are read"),
    "a zip without": (zipped(("end2end.bin", b"")), "holds no end2end.onnx"),
    "a zip with two": (
        zipped(("a/end2end.onnx", SIMCC), ("b/end2end.onnx", SIMCC)),
        "holds 2 end2end.onnx",
    ),
    "a zip that leads out": (zipped(("../end2end.onnx", SIMCC)), "holds no end2end.onnx"),
    "a zip of the root": (zipped(("/end2end.onnx", SIMCC)), "holds no end2end.onnx"),
    "a zip cut short": (zipped(("end2end.onnx", SIMCC))[:-40], "it cannot be unpacked"),
    "a zip bomb": (zipped(("end2end.onnx", bytes(2**24))), "packed by no more than 20 to 1"),
}


@pytest.mark.parametrize("name", WRONG)
def test_whatever_else_is_one_sentence_and_leaves_nothing(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], name: str
) -> None:
    content, words = WRONG[name]
    assert add(tmp_path, content) == 2
    (said,) = capfd.readouterr().err.splitlines()
    assert words in said
    assert not added_folder().exists()


def test_a_network_of_animals_with_other_joints_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "rtmpose-m_simcc-ap10k_pt-aic-coco_210e-256x256.onnx"
    content = tiny.simcc(26)
    file.write_bytes(content)
    digest = hashlib.sha256(content).hexdigest()
    assert run("models", "add", "dogs", "--from", file, "--sha256", digest) == 2
    words = "is a network of 26 joints: of animals are read those with AP-10K's 17."
    assert words in capsys.readouterr().err
    assert not added_folder().exists()


def test_a_larger_file_is_not_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(networks, "LARGEST_BYTES", 2**16)
    for content in (SIMCC, zipped(("end2end.onnx", np.random.default_rng(0).bytes(2**15 * 3)))):
        assert add(tmp_path, content) == 2
        assert "larger than 0.0625 MB" in capsys.readouterr().err
    assert not added_folder().exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ("add", "Mine", "--from", "f"),
            "has 1 to 32 lower-case letters",
        ),
        (
            ("add", "../mine", "--from", "f"),
            "has 1 to 32 lower-case letters",
        ),
        (
            ("add", "m" * 33, "--from", "f"),
            "has 1 to 32 lower-case letters",
        ),
        (("add", "full", "--from", "f"), "comes with Keypose"),
        (("add", "heavy", "--from", "f", "--sha256", "0"), "leave out --sha256"),
        (("add", "mine", "--from", "nowhere"), "cannot be read"),
        (("add", "mine"), "keypose models add mine --from FILE --sha256 DIGEST"),
        (("remove",), "Name the network to remove"),
        (("remove", "thunder"), "comes with Keypose and cannot be removed"),
        (("remove", "heavy"), "No network 'heavy' was added"),
        (("remove", "../mine"), "No network '../mine' was added"),
        (("remove", "mine", "--sha256", "0"), "--sha256 belongs to"),
    ],
)
def test_wrong_arguments_are_reported_in_one_sentence(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], words: str
) -> None:
    assert run("models", *arguments) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("field", "other", "words"),
    [
        ("outputs", ["simcc_x"], "'mine' cannot be run by"),
        ("outputs", ["simcc_x", "other"], "'mine' cannot be run by"),
        ("layout", "COCO_WHOLEBODY_133", "'mine' is damaged: run `keypose models remove mine`"),
    ],
)
def test_a_network_that_is_not_as_it_was_added_is_refused_before_it_looks(
    tmp_path: Path, field: str, other: object, words: str
) -> None:
    assert add(tmp_path, SIMCC) == 0
    note = find_model("mine").path.with_suffix(".json")
    facts = json.loads(note.read_text())
    facts["heads"][field] = other
    note.write_text(json.dumps(facts))
    with pytest.raises(KeypointError) as refused:
        JointNetwork.open(find_model("mine"))
    assert words in str(refused.value)


def test_what_is_known_of_it_is_checked_when_it_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert add(tmp_path, SIMCC) == 0
    note = added_folder() / "mine.json"
    note.write_text(note.read_text().replace('"simcc"', '"shell"'))
    capsys.readouterr()
    assert run("models") == 0
    listed = capsys.readouterr().out.splitlines()
    assert "run `keypose models remove mine` and add it again" in listed[-1]
    assert len(listed) == 4
    assert run("models", "remove", "mine") == 0
    assert list(added_folder().iterdir()) == []


def test_a_file_that_changed_since_is_not_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert add(tmp_path, SIMCC) == 0
    (added_folder() / "mine.onnx").write_bytes(SIMCC + b"\0")
    out = ("--network", "mine", "--out", tmp_path / "out")
    assert run("draft", BALANCE / "balance.mp4", "--box", AROUND, "--frames", "0-1", *out) == 2
    assert "is damaged or is not the mine network" in capsys.readouterr().err


def test_another_file_takes_its_place(tmp_path: Path) -> None:
    assert add(tmp_path, SIMCC) == 0
    before = find_model("mine")
    assert add(tmp_path, tiny.maps()) == 0
    after = find_model("mine")
    assert (before.sha256, after.sha256) == tuple(
        hashlib.sha256(each).hexdigest() for each in (SIMCC, tiny.maps())
    )


PIPELINE = json.dumps(
    {
        "pipeline": {
            "tasks": [
                {
                    "name": "Preprocess",
                    "transforms": [
                        {"type": "Normalize", "mean": [0, 0, 0], "std": [255] * 3, "to_rgb": False}
                    ],
                }
            ]
        }
    }
).encode()


def test_a_zip_is_shown_pictures_as_its_pipeline_says_and_what_it_finds_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert add(tmp_path, zipped(("a/pipeline.json", PIPELINE), ("a/end2end.onnx", SIMCC))) == 0
    heads = find_model("mine").heads
    assert heads is not None
    assert heads.levels is not None
    assert (heads.levels.rgb, heads.levels.std) == (False, (255.0, 255.0, 255.0))
    out = capsys.readouterr().out
    assert re.search(r"It finds \d+ of 17 joints of a person in a test picture\.", out)
    assert "It is shown BGR, less 0, 0, 0, over 255, 255, 255." in out


def test_a_pipeline_elsewhere_in_the_zip_does_not_count(tmp_path: Path) -> None:
    assert add(tmp_path, zipped(("b/pipeline.json", PIPELINE), ("a/end2end.onnx", SIMCC))) == 0
    heads = find_model("mine").heads
    assert heads is not None
    assert heads.levels is None


def test_bins_are_told_by_their_shape_whatever_they_are_called(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert add(tmp_path, tiny.simcc(names=("output", "1337"))) == 0
    heads = find_model("mine").heads
    assert heads is not None
    assert (heads.kind, heads.outputs) == ("simcc", ("output", "1337"))


def test_what_opencv_computes_otherwise_needs_the_other_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where there are no wheels of it."""
    monkeypatch.setattr(recognise_network, "fast_is_here", lambda suffix: False)
    path = tmp_path / "network.onnx"
    path.write_bytes(tiny.simcc(also=[tiny.node("Softmax", ["seen"], "unasked", axis=1)]))
    words = r"has Softmax of operator set 11, which OpenCV computes otherwise.*pip install onnx"
    with pytest.raises(KeypointError, match=words):
        recognise_network.recognised(path, "It")


@pytest.mark.skipif(not runtimes.fast_is_here(runtimes.ONNX), reason="ONNX Runtime is not here")
def test_where_it_is_here_it_is_used_and_that_is_kept(tmp_path: Path) -> None:
    content = tiny.simcc(also=[tiny.node("Softmax", ["seen"], "unasked", axis=1)])
    assert add(tmp_path, content) == 0
    heads = find_model("mine").heads
    assert heads is not None
    assert heads.needs_fast
    assert add(tmp_path, SIMCC) == 0
    heads = find_model("mine").heads
    assert heads is not None
    assert not heads.needs_fast


class Killed(subprocess.Popen[bytes]):
    """A child that is ended by a signal, as by a library that a damaged network crashes."""

    def communicate(self, *given: Any, **named: Any) -> tuple[bytes, bytes]:
        self.kill()
        return super().communicate(*given, **named)


def test_a_network_that_ends_its_library_ends_a_process_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    monkeypatch.setattr("keypose.tracker.apart.subprocess.Popen", Killed)
    assert add(tmp_path, SIMCC) == 2
    assert "ends the library that runs it, or needs too much" in capsys.readouterr().err
    assert not added_folder().exists()
    assert list(temporary.iterdir()) == []


def test_what_an_adding_that_was_killed_left_goes_with_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    left = Scratch("network")
    (left.path / "mine.onnx").write_bytes(SIMCC)
    left._lock.release(force=True)  # as the system does of a process that was killed
    assert add(tmp_path, SIMCC) == 0
    assert list(temporary.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="modes say nothing here")
@pytest.mark.parametrize("mode", [0o777, 0o757, 0o1777])
def test_no_network_is_kept_where_other_users_may_write(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mode: int
) -> None:
    added_folder().mkdir(parents=True)
    added_folder().chmod(mode)
    assert add(tmp_path, SIMCC) == 2
    said = capsys.readouterr().err
    assert f"other users may write to '{added_folder()}': run chmod go-w on it" in said
    assert list(added_folder().iterdir()) == []
    added_folder().chmod(0o755)
    assert add(tmp_path, SIMCC) == 0
    for place in (added_folder(), added_folder() / "mine.json", added_folder().parent):
        before = place.stat().st_mode
        place.chmod(before | 0o002)
        with pytest.raises(KeypointError, match="cannot be read: other users may write to"):
            find_model("mine")
        place.chmod(before)
    assert find_model("mine").is_here


def test_what_was_checked_is_what_is_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert add(tmp_path, SIMCC) == 0
    picture = np.full((64, 64, 3), 90, np.uint8)
    model, region = find_model("mine"), Region(31.5, 31.5, 64.0)
    expected = JointNetwork.open(model).infer(picture, region)

    def exchanged(known: Model, content: bytes) -> bool:
        is_it = is_content(known, content)
        known.path.write_bytes(b"another file")
        return is_it

    monkeypatch.setattr(model_files, "is_content", exchanged)
    found = JointNetwork.open(model).infer(picture, region)
    assert found.uv.tobytes() == expected.uv.tobytes()
    with pytest.raises(KeypointError, match="is damaged or is not the mine network"):
        JointNetwork.open(model)
