"""What is promised of reading beside the program: whatever a file is, a sentence and no harm."""

from __future__ import annotations

import gzip
import io
import os
import pickle
import resource
import signal
import struct
import subprocess
import sys
import threading
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.surface.files import reading, wire
from keypose.tracker.surface.files.parsing import raw
from keypose.tracker.surface.files.parsing.raw import MeshRefused
from keypose.tracker.surface.files.reading import MeshReader
from tests.tracker.surface.mesh_files import BOX, CORNERS, GlbFile, obj, ply, standing_box

GOOD = ply()


@pytest.fixture(scope="module")
def reader() -> Iterator[MeshReader]:
    with MeshReader() as reader:
        yield reader


def refusal(reader: MeshReader, path: Path) -> str:
    with pytest.raises(MeshRefused) as caught:
        reader.mesh(path)
    return str(caught.value)


def zip_bomb() -> bytes:
    """64 MB of nothing in 64 kB."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("mesh.ply", bytes(64 * 2**20))
    return content.getvalue()


def glb_of(document: str) -> bytes:
    """A GLB file with this document and no numbers."""
    text = document.encode("utf-8", "surrogatepass")
    return struct.pack("<4sIIII", b"glTF", 2, 20 + len(text), len(text), 0x4E4F534A) + text


BILLION = """{"bufferViews": [], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"accessors": [{"count": 1000000000, "type": "VEC3", "componentType": 5126},
{"count": 3, "type": "SCALAR", "componentType": 5125}]}"""
"""A document of a billion vertices, all zero because it keeps no numbers for them."""


def crowd() -> bytes:
    """A GLB file that shows one mesh of 20,000 vertices 300 times."""
    glb = GlbFile()
    soup = CORNERS[np.arange(20_000) % 8]
    faces = glb.numbers(np.arange(19_998), "u2")
    mesh = glb.mesh({"attributes": {"POSITION": glb.numbers(soup)}, "indices": faces})
    for _ in range(300):
        glb.node(mesh=mesh)
    return glb.content()


def memory_of(pid: int) -> int:
    """The most memory a process ever had, bytes."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    (peak,) = (line for line in lines if line.startswith("VmHWM"))
    return int(peak.split()[1]) * 1024


def test_a_mesh_arrives_as_it_was_written(reader: MeshReader, tmp_path: Path) -> None:
    path = tmp_path / "box.PLY"
    path.write_bytes(ply(extra={"zncc": np.linspace(0, 1, 8)}))
    mesh = reader.mesh(path)
    np.testing.assert_array_equal(mesh.faces, BOX)
    np.testing.assert_allclose(mesh.vertices, CORNERS, atol=1e-6)
    assert mesh.consistency is not None
    np.testing.assert_allclose(mesh.consistency, np.linspace(0, 1, 8), atol=1e-6)


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("empty.ply", b"", "is empty"),
        ("bomb.ply", zip_bomb(), "is a zip archive"),
        ("bomb.obj", zip_bomb(), "is a zip archive"),
        ("bomb.glb", zip_bomb(), "is a zip archive"),
        ("bomb.obj", gzip.compress(bytes(2**20)), "is a gzip archive"),
        ("snake.ply", pickle.dumps({"a": 1}), "does not begin as a PLY file"),
        ("snake.obj", pickle.dumps({"a": 1}), "no text"),
        ("snake.glb", pickle.dumps({"a": 1}), "does not begin as a GLB file"),
        ("nan.ply", ply(CORNERS + np.array([0, np.nan, 0])), "not finite"),
        ("points.ply", ply(faces=[]), "no faces, only points"),
        ("range.ply", ply(faces=BOX + 1), "not among its vertices"),
        ("short.ply", GOOD[:-7], "cut short"),
        ("odd.ply", GOOD.replace(b"float x", b"float \xff"), "where its vertices are"),
        ("deep.glb", glb_of("[" * 200_000), "is a damaged GLB file"),
        ("strange.glb", standing_box().replace(b'"mesh": 0', b'"mesh":[]'), "cannot be read"),
        ("digits.glb", glb_of('{"accessors": ' + "9" * 5000 + "}"), "is a damaged GLB file"),
        ("text.glb", glb_of("\ud800" * 9), "is a damaged GLB file"),
        ("list.glb", glb_of("[]"), "is a damaged GLB file"),
        ("zeros.glb", glb_of(BILLION), "too much memory"),
        ("crowd.glb", crowd(), "6,000,000 vertices"),
        ("rows.obj", b"v 0 0 0\n" * 9 + b"f" + b" 1" * 3_000_000 + b"\n", "2,999,998 faces"),
        ("lists.ply", GOOD.replace(b"list uchar", b"list int64"), "impossible length"),
        ("stranger.glb", standing_box().replace(b'"count": 8', b'"coont": 8'), "cannot be read"),
    ],
)  # fmt: skip
def test_a_bad_file_gives_one_sentence_and_the_next_one_is_read(
    reader: MeshReader, tmp_path: Path, name: str, content: bytes, words: str
) -> None:
    (tmp_path / name).write_bytes(content)
    (tmp_path / "good.ply").write_bytes(GOOD)
    sentence = refusal(reader, tmp_path / name)
    assert words in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence
    assert len(reader.mesh(tmp_path / "good.ply").faces) == 12


def test_what_is_not_a_regular_file_is_not_waited_for(reader: MeshReader, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.ply")
    (tmp_path / "zero.ply").symlink_to("/dev/zero")
    (tmp_path / "folder.ply").mkdir()
    for name in ("pipe.ply", "zero.ply", "folder.ply"):
        assert "not a regular file" in refusal(reader, tmp_path / name)
    (tmp_path / "nowhere.ply").symlink_to("gone.ply")
    assert "no longer there" in refusal(reader, tmp_path / "nowhere.ply")


def test_a_link_to_a_mesh_is_read(reader: MeshReader, tmp_path: Path) -> None:
    (tmp_path / "good.ply").write_bytes(GOOD)
    (tmp_path / "link.ply").symlink_to("good.ply")
    assert len(reader.mesh(tmp_path / "link.ply").faces) == 12


def test_a_name_of_any_bytes_is_read(reader: MeshReader, tmp_path: Path) -> None:
    path = Path(os.fsdecode(os.fsencode(tmp_path) + b"/mesh_\xff\n\"'.ply"))
    path.write_bytes(GOOD)
    assert len(reader.mesh(path).faces) == 12


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_ten_million_faces_are_refused_before_they_are_read(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"huge{suffix}"
    if suffix == ".ply":
        path.write_bytes(GOOD.replace(b"element face 12", b"element face 10000000"))
        os.truncate(path, 400 * 2**20)  # as large as it would be, with nothing in it
    else:
        path.write_bytes(b"\nv 0 0 0\n" + b"\nf 1 2 3" * 10_000_000)
    with MeshReader() as reader:
        assert "10,000,000 faces" in refusal(reader, path)
        assert reader._child is not None
        assert memory_of(reader._child.pid) < 200 * 2**20


def test_a_file_larger_than_is_read_is_refused_unopened(reader: MeshReader, tmp_path: Path) -> None:
    path = tmp_path / "huge.obj"
    path.touch()
    os.truncate(path, raw.LARGEST_BYTES + 2**20)
    assert "513 MB large" in refusal(reader, path)


def test_a_child_that_wants_too_much_memory_ends_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "large.obj"
    path.write_bytes(obj() + b"# nothing\n" * 8_000_000)
    (tmp_path / "good.ply").write_bytes(GOOD)
    with MeshReader(memory_bytes=64 * 2**20) as reader:
        assert "too much memory" in refusal(reader, path)
        assert len(reader.mesh(tmp_path / "good.ply").faces) == 12
    with MeshReader() as reader:
        assert len(reader.mesh(path).faces) == 12


def paused_child(reader: MeshReader, folder: Path) -> int:
    """The process of a reader that will not come to what it is asked next."""
    (folder / "good.ply").write_bytes(GOOD)
    reader.mesh(folder / "good.ply")
    assert reader._child is not None
    os.kill(reader._child.pid, signal.SIGSTOP)
    return reader._child.pid


def test_a_child_that_takes_too_long_ends_in_a_sentence(tmp_path: Path) -> None:
    with MeshReader() as reader:
        paused_child(reader, tmp_path)
        usual = reader._limits
        reader._limits = (usual[0], 1)
        assert "longer than 1 s" in refusal(reader, tmp_path / "good.ply")
        reader._limits = usual
        assert len(reader.mesh(tmp_path / "good.ply").faces) == 12


def test_a_child_that_is_killed_is_started_anew(reader: MeshReader, tmp_path: Path) -> None:
    (tmp_path / "good.ply").write_bytes(GOOD)
    reader.mesh(tmp_path / "good.ply")
    child = reader._child
    assert child is not None
    child.kill()
    child.wait()
    assert len(reader.mesh(tmp_path / "good.ply").faces) == 12


def test_a_child_that_dies_over_a_file_ends_in_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with MeshReader() as reader:
        child, ask = paused_child(reader, tmp_path), reading.ask

        def ask_and_die(*question: Any) -> None:
            ask(*question)
            os.kill(child, signal.SIGSEGV)
            os.kill(child, signal.SIGCONT)

        with monkeypatch.context() as patched:
            patched.setattr(reading, "ask", ask_and_die)
            assert "cannot be read" in refusal(reader, tmp_path / "good.ply")
        assert len(reader.mesh(tmp_path / "good.ply").faces) == 12


def test_threads_may_share_a_reader(reader: MeshReader, tmp_path: Path) -> None:
    found: dict[int, list[float]] = {}
    for number in range(8):
        (tmp_path / f"{number}.ply").write_bytes(ply(CORNERS + number))

    def read(number: int) -> None:
        found[number] = [reader.mesh(tmp_path / f"{number}.ply").vertices[0, 0] for _ in range(10)]

    threads = [threading.Thread(target=read, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == {number: [float(number)] * 10 for number in range(8)}


def test_no_child_outlives_its_reader(tmp_path: Path) -> None:
    (tmp_path / "good.ply").write_bytes(GOOD)
    reader = MeshReader()
    reader.mesh(tmp_path / "good.ply")
    assert reader._child is not None
    child = reader._child
    del reader
    assert child.poll() is not None


def test_no_child_outlives_a_program_that_is_killed(tmp_path: Path) -> None:
    (tmp_path / "good.ply").write_bytes(GOOD)
    code = (
        "import sys, time; from pathlib import Path; from keypose.tracker.surface.files.reading "
        "import *\n"
        "reader = MeshReader(); reader.mesh(Path(sys.argv[1]))\n"
        "print(reader._child.pid, flush=True); time.sleep(60)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code, str(tmp_path / "good.ply")], stdout=subprocess.PIPE, text=True
    ) as program:
        assert program.stdout is not None
        child = int(program.stdout.readline())
        program.kill()
    deadline = time.monotonic() + 300
    while is_running(child) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not is_running(child)


def is_running(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_a_module_in_the_present_folder_is_not_taken_for_a_part_of_the_program(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "numpy.py").write_text("raise SystemExit(7)")
    (tmp_path / "good.ply").write_bytes(GOOD)
    monkeypatch.chdir(tmp_path)
    with MeshReader() as reader:
        assert len(reader.mesh(tmp_path / "good.ply").faces) == 12


def test_a_child_may_write_no_file(tmp_path: Path) -> None:
    code = (
        "from keypose.tracker.limits import limit_memory; limit_memory(10**9)\n"
        f"open({str(tmp_path / 'written')!r}, 'wb', buffering=0).write(b'something')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert b"File too large" in done.stderr
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY  # only there


# --- what a child that was taken over may say ---------------------------------------------------


@pytest.mark.parametrize(
    "arrays",
    [
        {},
        {"vertices": CORNERS},
        {"vertices": CORNERS, "faces": BOX + 1},
        {"vertices": CORNERS, "faces": BOX - 1},
        {"vertices": CORNERS + np.inf, "faces": BOX},
        {"vertices": CORNERS[:, :2], "faces": BOX},
        {"vertices": CORNERS, "faces": BOX.astype(float)},
        {"vertices": CORNERS, "faces": BOX[:0]},
        {"vertices": CORNERS, "faces": BOX, "consistency": np.zeros(7)},
        {"vertices": CORNERS, "faces": BOX, "consistency": np.full(8, 1.5)},
        {"vertices": CORNERS, "faces": BOX, "consistency": np.full(8, np.nan)},
    ],
)
def test_an_answer_that_is_no_surface_is_not_believed(arrays: dict[str, np.ndarray]) -> None:
    with pytest.raises(MeshRefused):
        reading._mesh(arrays)


def test_an_answer_arrives_as_it_was_sent() -> None:
    stream = io.BytesIO()
    wire.answer(stream, {"leaving": True}, {"vertices": CORNERS, "faces": BOX})
    stream.seek(0)
    facts, arrays = wire.receive(stream)
    assert facts == {"leaving": True}
    np.testing.assert_array_equal(arrays["vertices"], CORNERS)
    np.testing.assert_array_equal(arrays["faces"], BOX)


@pytest.mark.parametrize(
    "header",
    [
        b"[]",
        b"{}",
        b'{"facts": {}, "arrays": [["v", "float", 99999999, 99999999]]}',
        b'{"facts": {}, "arrays": [["v", "float", -1, -1]]}',
        b'{"facts": {}, "arrays": [["v", "object", 1]]}',
        b'{"facts": {}, "arrays": [["v", "float", 4]]}',
        b'{"facts": {}, "arrays": [["v", "float"]]}',
        b"\xff" * 9,
    ],
)
def test_an_answer_that_is_nonsense_breaks_off(header: bytes) -> None:
    with pytest.raises(wire.BrokenConnection):
        wire.receive(io.BytesIO(struct.pack("<Q", len(header)) + header + bytes(16)))
    with pytest.raises(wire.BrokenConnection):
        wire.receive(io.BytesIO(struct.pack("<Q", 2**60)))


def header(text: str) -> bytes:
    """An answer without arrays."""
    return struct.pack("<Q", len(text)) + text.encode()


@pytest.mark.parametrize(
    "text",
    [
        '{"facts": {}, "arrays": [["a", "float", Infinity]]}',
        '{"facts": ' + "[" * 30_000 + "]" * 30_000 + ', "arrays": []}',
        '{"facts": {}, "arrays": [["a"]]}',
        '{"facts": {}, "arrays": [["a", "float"]]}',
        '{"facts": {}, "arrays": [["a", "money", 3]]}',
        "[]",
    ],
    ids=["infinite", "deep", "short", "shapeless", "unknown", "bare"],
)
def test_nonsense_of_a_spoilt_child_is_known_as_such(text: str) -> None:
    with pytest.raises(wire.BrokenConnection):
        wire.receive(io.BytesIO(header(text)))
