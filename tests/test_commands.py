"""Every command that a README or --help shows is one that works, in an empty folder, in order."""

from __future__ import annotations

import hashlib
import json
import re
import shlex
import shutil
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import av
import numpy as np
import pytest

from keypose.app.cli import many
from keypose.app.cli.main import grammar, main
from keypose.tracker.keypoints import find_people
from keypose.tracker.keypoints.model_files import cache_folder
from keypose.tracker.storage.files import load_session, save_session
from tests.animals.dot_network import dot_network
from tests.animals.walking import Walk
from tests.app.jobs.batch.batch_cases import Here
from tests.app.serving import ROOT
from tests.tracker.keypoints import tiny_networks as tiny

SAMPLES = ROOT / "sample_videos"
TOP_PX = 110
"""Cut from the top of a film, so that the man in it stands in the box that examples draw."""
SHOWN = re.compile(r"^(?:\.venv/bin/)?keypose( .*)?$")

BRIGHTEST = tiny.simcc()
"""A network that takes what is brightest for every joint."""

LEFT_OUT: Mapping[str, str] = {
    "side.mp4": "wants a film of another camera: tests/app/jobs/test_add_film.py",
    "scheduler": "wants a cluster: tests/app/jobs/batch/test_cluster.py",
    "models add heavy": "wants a download: tests/app/cli/test_models.py",
    ".osim": "wants a model of OpenSim's: tests/app/export/test_opensim_files.py",
    "--background hall.png": "wants a camera that turns: tests/app/cli/test_camera.py",
    "hull cameras.json": "wants cameras and silhouettes: tests/app/cli/test_hull.py",
    "openpose/": "wants other programs' files: tests/tracker/formats",
    "dogDLC.h5": "wants other programs' files: tests/tracker/formats",
    "names.json": "wants other programs' files: tests/app/export/test_import_motion.py",
}
"""Examples that want what cannot be made here, by a part of them, and what tests them."""


def shown_in_readme(path: Path) -> list[str]:
    """The commands of a README's blocks, as what follows `keypose`, in order."""
    lines, block = [], None
    for line in path.read_text("utf-8").splitlines():
        if line.startswith("```"):
            block = None if block is not None else line
        elif block == "```" and (found := SHOWN.match(line.partition(" #")[0].rstrip())):
            lines.append(found[1] or "")
    return lines


def shown_in_help(command: str) -> list[str]:
    """The examples of a command, as what follows `keypose`, in order."""
    text = grammar()[1][command].format_help().partition("\nexamples:\n")[2]
    lines = re.findall(r"^  keypose( .+)$", text, re.M)
    return [line.partition(" > ")[0] for line in lines]


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a film and its session, drafted, tracked and stood on the floor."""
    folder = tmp_path_factory.mktemp("ready")
    film, session = folder / "jump.mp4", str(folder / "jump.keypose")
    write_film(film)
    box = ("--box", "210,80,420,610", "--frame", "12")
    some = ("--frames", "0-50")  # so that there is something ahead of the last keyframe
    assert main(["draft", str(film), *box, *some, "--accept", "--out", session]) == 0
    assert main(["track", session]) == 0
    return folder


def write_film(path: Path) -> None:
    """The man on the beam, cut at the top."""
    with av.open(SAMPLES / "balance" / "balance.mp4") as source, av.open(path, "w") as film:
        pictures = [frame.to_ndarray(format="rgb24") for frame in source.decode(video=0)]
        height, width, _ = pictures[0][TOP_PX:].shape
        stream = film.add_stream("libx264", rate=60, options={"crf": "18"})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture[TOP_PX:]), "rgb24")
            film.mux(stream.encode(frame))
        film.mux(stream.encode())


def done(line: str) -> int:
    """Run a line, in this process or, of the page, until it is served; its exit code."""
    words = [part for word in shlex.split(line) for part in expanded(word)]
    if not words or words[0] == "open":
        return served(words or ["open"])
    try:
        return main(words)
    except SystemExit as ended:
        return int(ended.code or 0)


def expanded(word: str) -> list[str]:
    """A word as a shell gives it to a program."""
    return sorted(map(str, Path().glob(word))) if "*" in word else [word]


def served(words: list[str]) -> int:
    """Open the page, see that it is there, and end it."""
    command = [sys.executable, "-m", "keypose.app", *words, "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as page:
        assert page.stdout is not None
        assert page.stdout.readline().startswith("Keypose is at http://127.0.0.1:")
        page.send_signal(signal.SIGINT)
        return page.wait()


def is_left_out(line: str) -> bool:
    return any(part in line for part in LEFT_OUT)


@pytest.mark.parametrize("command", sorted(grammar()[1]))
def test_every_example_is_in_the_grammar_of_its_command(command: str) -> None:
    lines = shown_in_help(command)
    assert any(shlex.split(line)[0] == command for line in lines)
    for line in lines:
        _, further = grammar()[0].parse_known_args(shlex.split(line))
        assert further == []


def test_what_is_left_out_is_shown_somewhere_and_tested_elsewhere() -> None:
    shown = [line for name in grammar()[1] for line in shown_in_help(name)]
    for part, reason in LEFT_OUT.items():
        assert any(part in line for line in shown), part
        assert (ROOT / reason.rpartition(" ")[2]).exists(), part


# --- READMEs


def test_the_road_of_the_first_readme_leads_from_a_film_to_motion(
    ready: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(find_people, "FRAMES", 2)
    monkeypatch.setattr(many, "LocalPool", Here)  # processes of their own have their own tests
    monkeypatch.chdir(tmp_path)
    shutil.copy(ready / "jump.mp4", tmp_path)
    lines = shown_in_readme(ROOT / "README.md")
    assert len(lines) >= 7
    for line in lines:
        assert done(line) == 0, line
    assert (tmp_path / "motion" / "jump.keypose" / "motion.glb").is_file()
    assert (tmp_path / "motion" / "files" / "motion.bvh").is_file()


def test_the_commands_of_the_programs_readme_run_in_order(
    ready: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sample_videos").symlink_to(SAMPLES)
    shutil.copytree(ready / "jump.keypose", tmp_path / "jump.keypose")
    shutil.copy(ready / "jump.mp4", tmp_path)
    with_network(tmp_path / "rtmw-x.zip")
    with_network(tmp_path / "rtmpose-m-ap10k.zip", dot_network())
    Walk("dog", frames=3).film(tmp_path / "dog.mp4")  # a folder of pictures, whatever it is called
    with_scans(tmp_path / "scans")
    documents = (ROOT / "app" / "README.md", *sorted((ROOT / "docs").glob("*.md")))
    lines = [line for document in documents for line in shown_in_readme(document)]
    assert len(lines) >= 12
    for line in lines:
        assert done(with_digest(line)) in (0, 1), line  # 1: lost somewhere


def with_digest(line: str) -> str:
    """A command with the digest of the file that it names."""
    named = re.search(r"--from (\S+)", line)
    if named is None or "DIGEST" not in line:
        return line
    return line.replace("DIGEST", hashlib.sha256(Path(named[1]).read_bytes()).hexdigest())


def with_network(path: Path, content: bytes = BRIGHTEST) -> None:
    """A network of one's own."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("end2end.onnx", content)


def with_scans(folder: Path) -> None:
    folder.mkdir()
    for mesh in sorted((SAMPLES / "arms" / "meshes").iterdir())[:3]:
        shutil.copy(mesh, folder)


# --- the examples of --help


def for_models(folder: Path) -> None:
    with_network(folder / "rtmw-x.zip")
    shutil.copy(folder / "rtmw-x.zip", folder / "rtmpose-m-ap10k.zip")


def for_batch(folder: Path) -> None:
    (folder / "films.csv").write_text("film\njump.mp4\n")


def for_draft(folder: Path) -> None:
    shutil.rmtree(folder / "jump.keypose")


def for_fit(folder: Path) -> None:
    """The sample's surfaces and, where each form of the command looks for it, their session."""
    shutil.rmtree(folder / "scan")
    shutil.copytree(SAMPLES / "arms" / "meshes", folder / "scan")
    session = load_session(SAMPLES / "arms" / "session.json")
    (folder / "scan.keypose").mkdir()
    for place, meshes in (("scan.keypose", "../scan"), (".", "scan")):
        there = session.evidence.with_paths(lambda _, meshes=meshes: meshes)
        save_session(session.changed(there), folder / place / "session.json")


def for_import(folder: Path) -> None:
    main(["export", "session.json", "--format", "bvh,chan", "--out", "made"])
    shutil.copy(folder / "made" / "motion.bvh", folder / "walk.bvh")
    lines = (folder / "made" / "motion_camera.chan").read_text().splitlines()
    (folder / "shot.chan").write_text("\n".join(lines))
    numbered = (line.partition("\t") for line in lines)
    plate = [f"{int(frame) + 1001}\t{rest}" for frame, _, rest in numbered]
    (folder / "plate.chan").write_text("\n".join(plate))


def for_evaluate(folder: Path) -> None:
    main(["export", "session.json", "--format", "npz", "--out", "made"])
    shutil.copy(folder / "made" / "motion.npz", folder / "truth.npz")
    marks = {"frames": {"30": {"left_forearm": [284, 300]}}}
    (folder / "marked_joints.json").write_text(json.dumps(marks))


def quick(path: Path) -> None:
    """Let a session be tracked as a preview."""
    session = load_session(path)
    settings = session.settings.model_copy(update={"quality": "preview"})
    save_session(session.changed({"settings": settings}), path)


def with_session_beside(folder: Path) -> None:
    """A session beside its film, which commands find without a name."""
    shutil.copytree(folder / "jump.keypose", folder, dirs_exist_ok=True)
    session = load_session(folder / "jump.keypose" / "session.json")
    beside = session.evidence.with_paths(lambda path: Path(path).name)
    save_session(session.changed(beside), folder / "session.json")


MAY_BE_LOST = ("batch", "fit", "track")
"""Commands that end with 1 where tracking was lost somewhere, as previews of few frames may be."""

PREPARED: Mapping[str, Callable[[Path], None]] = {
    "batch": for_batch,
    "draft": for_draft,
    "evaluate": for_evaluate,
    "fit": for_fit,
    "import": for_import,
    "models": for_models,
}


@pytest.mark.parametrize("command", sorted(grammar()[1]))
def test_the_examples_of_a_command_run_in_order(
    ready: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    lines = [line for line in shown_in_help(command) if not is_left_out(line)]
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    cache = tmp_path if command == "models" else cache_folder().parent
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))  # where the compiled loops are
    monkeypatch.setattr(many, "LocalPool", Here)
    monkeypatch.setattr(find_people, "FRAMES", 2)
    config = tmp_path / "config.toml"
    config.write_text('quality = "preview"\n')
    monkeypatch.setenv("KEYPOSE_CONFIG", str(config))
    folder = tmp_path / "here"
    for place in (folder / "jump.keypose", folder / "recordings" / "jump.keypose"):
        shutil.copytree(ready / "jump.keypose", place)
        shutil.copy(ready / "jump.mp4", place.parent)
        if command != "stand":  # which wants a motion tracked in full
            quick(place / "session.json")
    with_session_beside(folder)
    (folder / "sample_videos").symlink_to(SAMPLES)
    with_scans(folder / "scan")
    monkeypatch.chdir(folder)
    if command in PREPARED:
        PREPARED[command](folder)
    good = (0, 1) if command in MAY_BE_LOST else (0,)
    for line in lines:
        assert done(with_digest(line)) in good, line
