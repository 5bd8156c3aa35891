"""What is promised of meshes over time: every step keeps its number, whatever becomes of others."""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import SurfaceError
from keypose.tracker.surface.files.sequence import MeshSequence, describe_unusable
from keypose.tracker.surface.files.sources import FolderSource
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.new_session import guess_units, guess_up
from tests.tracker.surface.mesh_files import BOX, CORNERS, folder_of, obj, ply, standing_box


def place_x(meshes: MeshSequence, frame: int) -> float:
    """Where the box of a step stands: `folder_of` lets it wander one unit a step."""
    return float(meshes.mesh(frame).vertices[0, 0])


def sentence_of(meshes: MeshSequence, frame: int) -> str:
    with pytest.raises(SurfaceError) as caught:
        meshes.mesh(frame)
    sentence = str(caught.value)
    assert sentence.endswith(".")
    assert sentence.count(". ") == 0
    assert meshes.missing[frame] == sentence
    return sentence


def refusal(path: Path) -> str:
    with pytest.raises(SurfaceError) as caught:
        MeshSequence.open(path)
    return str(caught.value)


def named(folder: Path, *names: str) -> Path:
    """A folder of boxes with these names, the first at x = 0, the next at 1 …"""
    folder.mkdir()
    for number, name in enumerate(names):
        (folder / name).write_bytes(ply(CORNERS + np.array([number, 0, 0])))
    return folder


# --- steps and numbers --------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
def test_a_folder_gives_one_mesh_per_step(tmp_path: Path, suffix: str) -> None:
    with MeshSequence.open(folder_of(tmp_path / "scan", 12, suffix)) as meshes:
        assert meshes.frame_count == 12
        assert [place_x(meshes, frame) for frame in (11, 0, 5)] == [11, 0, 5]
        np.testing.assert_array_equal(meshes.mesh(5).faces, BOX)
        assert meshes.missing == {}
        assert (meshes.stated_units, meshes.stated_up) == (None, None)


def test_numbers_order_the_steps_by_value(tmp_path: Path) -> None:
    folder = named(tmp_path / "scan", "b8.ply", "b9.ply", "b10.ply", "b11.ply")
    with MeshSequence.open(folder) as meshes:
        assert [place_x(meshes, frame) for frame in range(4)] == [0, 1, 2, 3]


def test_a_missing_number_is_a_missing_step_and_nothing_shifts(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 9)
    (folder / "mesh_005.ply").unlink()
    with MeshSequence.open(folder) as meshes:
        assert meshes.frame_count == 9
        assert [*meshes.missing] == [5]
        assert "mesh_004.ply" in sentence_of(meshes, 5)
        assert "mesh_006.ply" in sentence_of(meshes, 5)
        assert [place_x(meshes, frame) for frame in (4, 6, 8)] == [4, 6, 8]


def test_the_first_number_is_the_first_step(tmp_path: Path) -> None:
    folder = named(tmp_path / "scan", "mesh_0104.ply", "mesh_0106.ply")
    with MeshSequence.open(folder) as meshes:
        assert meshes.frame_count == 3
        assert [*meshes.missing] == [1]
        assert place_x(meshes, 2) == 1


def test_every_tenth_number_is_one_step(tmp_path: Path) -> None:
    folder = named(tmp_path / "scan", *(f"f{10 * k:05d}.ply" for k in (0, 1, 2, 4, 5)))
    with MeshSequence.open(folder) as meshes:
        assert meshes.frame_count == 6
        assert [*meshes.missing] == [3]
        assert place_x(meshes, 5) == 4


def test_the_last_number_that_differs_is_the_step(tmp_path: Path) -> None:
    names = [f"take2_{k:04d}_v3.ply" for k in (7, 8, 10)]
    with MeshSequence.open(named(tmp_path / "scan", *names)) as meshes:
        assert meshes.frame_count == 4
        assert [*meshes.missing] == [2]


def test_numbers_that_are_times_are_an_order_and_no_steps(tmp_path: Path) -> None:
    names = [f"scan_{t}.ply" for t in (1_700_000_000_000, 1_700_000_033_001, 1_700_000_066_007)]
    with MeshSequence.open(named(tmp_path / "scan", *names)) as meshes:
        assert meshes.frame_count == 3
        assert meshes.missing == {}


def test_names_without_numbers_are_in_their_own_order(tmp_path: Path) -> None:
    folder = named(tmp_path / "scan", "a.ply", "b.ply", "C.ply")
    with MeshSequence.open(folder) as meshes:
        assert [place_x(meshes, frame) for frame in range(3)] == [0, 1, 2]


def test_what_else_lies_in_the_folder_is_no_step(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 3)
    (folder / "template.ply").write_bytes(ply())
    (folder / "texture_003.png").write_bytes(b"\x89PNG")
    (folder / "notes.txt").write_text("hello")
    (folder / "._mesh_001.ply").write_bytes(b"what a file manager leaves behind")
    (folder / "mesh_007.ply").mkdir()
    with MeshSequence.open(folder) as meshes:
        assert meshes.frame_count == 3
        assert [place_x(meshes, frame) for frame in range(3)] == [0, 1, 2]


def test_kinds_of_files_may_be_mixed_but_not_for_one_step(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 3)
    (folder / "mesh_003.obj").write_bytes(obj(CORNERS + np.array([3, 0, 0])))
    with MeshSequence.open(folder) as meshes:
        assert place_x(meshes, 3) == 3
    (folder / "mesh_001.obj").write_bytes(obj())
    assert '"mesh_001.obj" and "mesh_001.ply" have the same number' in refusal(folder)


def test_a_single_mesh_is_a_single_step(tmp_path: Path) -> None:
    with MeshSequence.open(named(tmp_path / "scan", "mesh_0104.ply")) as meshes:
        assert meshes.frame_count == 1
        assert len(meshes.mesh(0).faces) == 12


def test_a_folder_of_glb_files_is_one_step_each(tmp_path: Path) -> None:
    for step in (1, 2, 4):
        (tmp_path / f"{step}.glb").write_bytes(standing_box())
    with MeshSequence.open(tmp_path) as meshes:
        assert meshes.frame_count == 4
        assert [*meshes.missing] == [2]
        assert (meshes.stated_units, meshes.stated_up) == ("m", "+y")
        np.testing.assert_allclose(meshes.mesh(3).extent, [0.5, 0.3, 1.7], atol=1e-6)


@pytest.mark.parametrize("frame", [-1, 3, 10**9])
def test_a_step_beyond_the_ends_is_reported_in_a_sentence(tmp_path: Path, frame: int) -> None:
    with (
        MeshSequence.open(folder_of(tmp_path / "scan", 3)) as meshes,
        pytest.raises(SurfaceError, match=f"no step {frame}: the meshes end at step 2"),
    ):
        meshes.mesh(frame)


# --- steps that cannot be used ------------------------------------------------------------------


def test_a_bad_step_is_reported_with_its_file_and_the_others_are_kept(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 8)
    (folder / "mesh_003.ply").write_bytes(b"")
    (folder / "mesh_004.ply").write_bytes(ply()[:-3])
    (folder / "mesh_005.ply").unlink()
    os.mkfifo(folder / "mesh_005.ply")
    with MeshSequence.open(folder) as meshes:
        assert sentence_of(meshes, 3) == 'Step 3 ("mesh_003.ply") is empty: export it again.'
        assert "cut short" in sentence_of(meshes, 4)
        assert "not a regular file" in sentence_of(meshes, 5)
        assert [place_x(meshes, frame) for frame in (0, 1, 2, 6, 7)] == [0, 1, 2, 6, 7]
        assert [*meshes.missing] == [3, 4, 5]


def test_a_file_taken_away_after_opening_is_reported(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 7)
    with MeshSequence.open(folder) as meshes:
        meshes.mesh(0)
        (folder / "mesh_006.ply").unlink()
        assert "is no longer there" in sentence_of(meshes, 6)


@pytest.mark.parametrize("scale", [100.0, 0.001, 1 / 0.0254])
def test_a_step_in_other_units_is_reported(tmp_path: Path, scale: float) -> None:
    folder = folder_of(tmp_path / "scan", 8)
    (folder / "mesh_006.ply").write_bytes(ply(CORNERS * scale))
    with MeshSequence.open(folder) as meshes:
        times = f"{max(scale, 1 / scale):,.0f} times {'larger' if scale > 1 else 'smaller'}"
        assert times in sentence_of(meshes, 6)
        assert "other units" in sentence_of(meshes, 6)
        assert place_x(meshes, 7) == 7


def test_a_first_step_in_other_units_does_not_decide_over_the_others(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 8)
    (folder / "mesh_000.ply").write_bytes(ply(CORNERS * 1000))
    with MeshSequence.open(folder) as meshes:
        assert place_x(meshes, 7) == 7
        assert "1,000 times larger" in sentence_of(meshes, 0)


def test_of_two_steps_one_decides(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 2)
    (folder / "mesh_001.ply").write_bytes(ply(CORNERS * 1000))
    with MeshSequence.open(folder) as meshes:
        assert place_x(meshes, 0) == 0
        assert "1,000 times larger" in sentence_of(meshes, 1)


def test_a_body_that_crouches_or_stretches_is_the_same_body(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 8)
    (folder / "mesh_006.ply").write_bytes(ply(CORNERS * [1, 1, 0.3]))
    (folder / "mesh_007.ply").write_bytes(ply(CORNERS * [3, 1, 1.4]))
    with MeshSequence.open(folder) as meshes:
        assert len(meshes.mesh(6).faces) == len(meshes.mesh(7).faces) == 12


def test_when_the_first_steps_are_all_bad_the_others_are_still_read(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 14)
    for step in range(12):
        (folder / f"mesh_{step:03d}.ply").write_bytes(b"")
    with MeshSequence.open(folder) as meshes:
        assert place_x(meshes, 13) == 13


@pytest.mark.parametrize("name", [b"mesh_\xff003.ply", b"mesh_\n003.ply"])
def test_a_name_of_any_bytes_can_be_reported(tmp_path: Path, name: bytes) -> None:
    folder = folder_of(tmp_path / "scan", 5)
    (folder / "mesh_003.ply").rename(os.fsdecode(os.fsencode(folder) + b"/" + name))
    with MeshSequence.open(folder) as meshes:
        assert place_x(meshes, 3) == 3
    (folder / os.fsdecode(name)).write_bytes(b"")
    with MeshSequence.open(folder) as meshes:
        sentence_of(meshes, 3).encode("utf-8")
        assert "\n" not in sentence_of(meshes, 3)


# --- what cannot be opened ----------------------------------------------------------------------


def test_what_holds_no_meshes_is_reported_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "film.mp4").write_bytes(b"film")
    (tmp_path / "one.ply").write_bytes(ply())
    (tmp_path / "film.glb").write_bytes(standing_box())
    assert "holds no meshes (PLY, OBJ, GLB)" in refusal(tmp_path / "empty")
    assert "holds no meshes over time" in refusal(tmp_path / "film.mp4")
    assert "of a single step" in refusal(tmp_path / "one.ply")
    assert "export numbered meshes, one per time step" in refusal(tmp_path / "film.glb")
    assert 'There is no "nowhere"' in refusal(tmp_path / "nowhere")
    assert 'There is no "nowhere.glb"' in refusal(tmp_path / "nowhere.glb")


# --- the same meshes ----------------------------------------------------------------------------


def fingerprint(path: Path) -> str:
    with MeshSequence.open(path) as meshes:
        return meshes.fingerprint()


def test_copies_have_one_fingerprint_and_other_meshes_another(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 4)
    first = fingerprint(folder)
    assert first.startswith("sha256:")
    assert fingerprint(shutil.copytree(folder, tmp_path / "copy")) == first
    (folder / "notes.txt").write_text("hello")
    assert fingerprint(folder) == first
    (folder / "mesh_002.ply").write_bytes(ply(CORNERS * 1.001))
    changed = fingerprint(folder)
    (folder / "mesh_002.ply").unlink()
    gone = fingerprint(folder)
    (folder / "mesh_003.ply").rename(folder / "mesh_002.ply")
    assert len({first, changed, gone, fingerprint(folder)}) == 4


def test_a_pipe_among_the_meshes_does_not_hold_up_the_fingerprint(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "scan", 2)
    os.mkfifo(folder / "mesh_002.ply")
    assert fingerprint(folder).startswith("sha256:")


def test_threads_may_share_a_sequence(tmp_path: Path) -> None:
    found: dict[int, float] = {}
    with MeshSequence.open(folder_of(tmp_path / "scan", 12)) as meshes:

        def read(frame: int) -> None:
            found[frame] = place_x(meshes, frame)

        threads = [threading.Thread(target=read, args=(frame,)) for frame in range(12)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert found == {frame: float(frame) for frame in range(12)}


# --- guesses ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("longest", "units"),
    [
        (1.8, "m"),
        (0.5, "m"),
        (172.0, "cm"),
        (1720.0, "mm"),
        (10.0, None),
        (0.01, None),
        (1e5, None),
    ],
)
def test_a_person_gives_the_units_and_a_house_does_not(longest: float, units: str | None) -> None:
    assert guess_units(longest) == units


@pytest.mark.parametrize(
    ("extent", "up"),
    [
        ([0.5, 1.7, 0.3], "+y"),
        ([0.5, 0.3, 1.7], "+z"),
        ([1.8, 0.3, 1.7], "+z"),
        ([1.7, 0.5, 0.3], "+x"),
    ],
)
def test_up_is_where_a_surface_is_longest(extent: list[float], up: str) -> None:
    box = CORNERS / np.ptp(CORNERS, axis=0) * extent
    assert guess_up(SurfaceMesh(box, BOX)) == up


def test_many_missing_steps_are_reported_at_once() -> None:
    """Every step is looked at once, however many are missing in a row."""

    class Counted(tuple[Path | None, ...]):
        looks = 0

        def __iter__(self) -> Iterator[Path | None]:
            for file in super().__iter__():
                Counted.looks += 1
                yield file

        def __getitem__(self, key: Any) -> Any:
            found = super().__getitem__(key)
            Counted.looks += len(found) if isinstance(key, slice) else 1
            return found

    count = 2001
    files = Counted(Path(f"{k}.ply") if k % (count - 1) == 0 else None for k in range(count))
    source = FolderSource(files)
    assert sorted(source.missing) == list(range(1, count - 1))
    assert 'between "0.ply" and "2000.ply"' in source.missing[7]
    assert Counted.looks < 10 * count


# --- what is wrong with steps -------------------------------------------------------------------


def test_what_is_wrong_with_a_step_is_told_and_it_can_still_be_asked_for(tmp_path: Path) -> None:
    folder = named(tmp_path / "scan", "a_1.ply", "a_2.ply", "a_4.ply")
    (folder / "a_2.ply").write_bytes(b"")
    with MeshSequence.open(folder) as meshes:
        told = [meshes.problem(frame) for frame in range(4)]
        assert told[1] == 'Step 1 ("a_2.ply") is empty: export it again.'
        assert "missing between" in told[2]
        assert told[0] == told[3] == ""
        (folder / "a_2.ply").write_bytes(ply())
        assert len(meshes.mesh(1).faces) == 12


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ([], ""),
        ([4], "Why 4."),
        ([7, 12], "Steps 7 and 12 cannot be used. The first of them: Why 7."),
        ([3, 7, 8, 9, 12], "Steps 3, 7–9 and 12 cannot be used. The first of them: Why 3."),
        (
            range(0, 40, 2),
            "Steps 0, 2, 4, 6, 8, 10, 12, 14 and 12 more cannot be used. The first of them: Why 0.",
        ),
    ],
)
def test_steps_that_cannot_be_used_are_named_in_a_sentence(steps: list[int], words: str) -> None:
    assert describe_unusable({step: f"Why {step}." for step in steps}) == words
