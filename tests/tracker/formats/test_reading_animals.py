"""Keypoints in, as SLEAP and DeepLabCut write them, and what is wrong with such files."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pytest

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.reading_keypoints import VideoFacts, load_keypoints
from tests.tracker.formats import animals

NAMES = ("nose", "Left ear", "tail_base")
UV = np.random.default_rng(1).uniform(20, 300, (2, 6, 3, 2))
"""Two animals, six frames, three keypoints."""
UV[0, 2, 1] = np.nan
ONE = UV[:1]
COLUMNS = animals.dlc_columns(NAMES)

WRITERS: dict[str, Callable[[Path], Path]] = {
    "SLEAP HDF5": lambda p: animals.sleap_h5(p / "a.h5", NAMES, ONE, np.full((1, 6, 3), 0.9)),
    "SLEAP HDF5, frames first": lambda p: animals.sleap_h5(p / "a.h5", NAMES, ONE, standard=True),
    "SLEAP CSV": lambda p: animals.sleap_csv(p / "a.csv", NAMES, ONE),
    "DLC CSV": lambda p: animals.dlc_csv(p / "a.csv", COLUMNS, animals.dlc_values(ONE)),
    "DLC table": lambda p: animals.dlc_table_h5(p / "a.h5", COLUMNS, animals.dlc_values(ONE)),
    "DLC fixed": lambda p: animals.dlc_fixed_h5(p / "a.h5", COLUMNS, animals.dlc_values(ONE)),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_keypoints_come_with_their_names_frames_and_gaps(tmp_path: Path, kind: str) -> None:
    found = load_keypoints(WRITERS[kind](tmp_path))
    assert found.names == ("nose", "left_ear", "tail_base")
    assert (found.first_frame, len(found)) == (0, 6)
    assert np.allclose(found.uv, UV[0], equal_nan=True)
    assert found.visibility[2, 1] == 0
    assert found.visibility[0, 0] == pytest.approx(1.0 if "first" in kind else 0.9)


def test_of_several_animals_one_is_named_and_none_is_guessed(tmp_path: Path) -> None:
    both = animals.dlc_columns(NAMES, ["rat", "mouse"])
    for path in (
        animals.sleap_h5(tmp_path / "s.h5", NAMES, UV, tracks=["rat", "mouse"]),
        animals.sleap_csv(tmp_path / "s.csv", NAMES, UV, tracks=["rat", "mouse"]),
        animals.dlc_csv(tmp_path / "d.csv", both, animals.dlc_values(UV)),
        animals.dlc_fixed_h5(tmp_path / "d.h5", both, animals.dlc_values(UV)),
    ):
        with pytest.raises(FormatError, match=r"2 individuals, rat and mouse\."):
            load_keypoints(path)
        with pytest.raises(FormatError, match="no individual 'cat'; it has rat and mouse"):
            load_keypoints(path, individual="cat")
        assert np.allclose(load_keypoints(path, individual="mouse").uv, UV[1])


def test_labelled_pictures_are_frames_by_their_numbers_and_seen_for_sure(tmp_path: Path) -> None:
    columns = [column for column in COLUMNS if column[-1] != "likelihood"]
    values = ONE[0, [0, 1]].reshape(2, -1)
    names = ["labeled-data/rat2/img0012.png", "labeled-data/rat2/img0031.png"]
    found = load_keypoints(animals.dlc_csv(tmp_path / "a.csv", columns, values, names))
    assert (found.first_frame, found.last_frame) == (12, 31)
    assert (found.visibility[[0, -1]] == 1).all()


def test_keypoints_of_another_film_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="frames are 0 to 2"):
        load_keypoints(WRITERS["DLC table"](tmp_path), video=VideoFacts(3, 640, 480))


def test_without_h5py_a_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = WRITERS["DLC fixed"](tmp_path)
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(FormatError, match=r"needs h5py: pip install 'keypose\[h5\]', or .* CSV"):
        load_keypoints(path)


# --- files that are broken or hostile


def _sentence(path: Path) -> str:
    with pytest.raises(FormatError) as caught:
        load_keypoints(path)
    words = str(caught.value)
    assert "\n" not in words
    assert words.endswith(".")
    return words


@pytest.mark.parametrize("kind", WRITERS)
def test_a_file_cut_short_or_overwritten_anywhere_is_reported_or_read(
    tmp_path: Path, kind: str
) -> None:
    path = WRITERS[kind](tmp_path)
    content, rng = path.read_bytes(), np.random.default_rng(2)
    for length in rng.integers(0, len(content) - 1, 12):
        path.write_bytes(content[:length])
        _read_or_refused(path)
    for place in rng.integers(0, len(content), 40):
        wrong = bytes(rng.integers(0, 256, 3, "u1"))
        path.write_bytes(content[:place] + wrong + content[place + 3 :])
        _read_or_refused(path)


def _read_or_refused(path: Path) -> None:
    with suppress(FormatError):
        load_keypoints(path)


@pytest.mark.parametrize(
    "dims", ['["x", "y", "z", "w"]', '["frame", "track", "node"]', "7", "[", "{}"]
)
def test_axes_that_are_not_the_four_are_reported_as_the_file_names_them(
    tmp_path: Path, dims: str
) -> None:
    path = animals.sleap_h5(tmp_path / "a.h5", NAMES, ONE)
    with h5py.File(path, "r+") as file:
        file["tracks"].attrs["dims"] = dims
    assert _sentence(path) == f"a.h5: its tracks names its axes {dims!r}."


def test_a_file_that_leads_to_another_file_is_refused(tmp_path: Path) -> None:
    other = WRITERS["SLEAP HDF5"](tmp_path)
    path = tmp_path / "link.h5"
    with h5py.File(path, "w") as file:
        file["tracks"] = h5py.ExternalLink(other.name, "/tracks")
        file["node_names"] = [b"nose"]
    assert "only a link to somewhere else" in _sentence(path)
    with h5py.File(path, "w") as file:
        secret = [(str(other), 0, 8)]
        file.create_dataset("tracks", (1,), "f8", external=secret)
        file["node_names"] = [b"nose"]
    assert "only a link to somewhere else" in _sentence(path)


def test_a_file_that_claims_more_than_it_holds_is_not_allocated(tmp_path: Path) -> None:
    path = tmp_path / "bomb.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("tracks", (1, 2, 3, 2**40), "f8", chunks=(1, 2, 3, 1024))
        file["node_names"] = [b"a", b"b", b"c"]
    assert "too many numbers" in _sentence(path)


class _Runs:
    """A pickle that would call something."""

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return (Path.touch, ("ran",))


def test_no_code_within_a_file_is_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = WRITERS["DLC table"](tmp_path)
    with h5py.File(path, "r+") as file:
        file["df_with_missing/table"].attrs["values_block_0_kind"] = np.bytes_(
            pickle.dumps([_Runs()], 0)
        )
    assert "names its columns in no way known" in _sentence(path)
    path = tmp_path / "labels.pickle"
    path.write_bytes(pickle.dumps(_Runs()))
    assert "may run code" in _sentence(path)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("a,b\n1,2\n", "no table of keypoints as SLEAP"),
        ("scorer,n,n\nbodyparts,nose,nose\n", "no row 'coords'"),
        ("scorer,n\nbodyparts,nose\ncoords,x\n0,1\n", "'nose' without x and y"),
        ("scorer,n,n,n\nbodyparts,a,a,a\ncoords,x,y,z\n0,1,2,3\n", "coordinates in space"),
        ("scorer,n,n\nbodyparts,a,a\ncoords,x,y\n0,1\n", "row 4 has 2 columns where 3"),
        ("scorer,n,n\nbodyparts,a,a\ncoords,x,y\n", "holds no frame"),
        ("scorer,n,n\nbodyparts,a,a\ncoords,x,y\n0,1,fish\n", "'fish' where a number"),
        ("scorer,n,n\nbodyparts,a,a\ncoords,x,y\n0,1,inf\n", "not a finite number"),
        ("scorer,n,n\nbodyparts,a,a\ncoords,x,y\n-4,1,2\n", "row '-4' that names no frame"),
        ("scorer,n,n\nbodyparts,a,a\ncoords,x,y\n4,1,2\n4,1,2\n", "frame 4 twice"),
        ("scorer,n,m\nbodyparts,a,a\ncoords,x,y\n4,1,2\n", "several scorers, n and m"),
        ("scorer,n,n\nbodyparts,a,a\ncoords,x,y\n4,,\n", "no keypoint of anybody"),
        ("track,frame_idx,a.x,a.y\n,-1,5,6\n", "numbered '-1'"),
        ("track,frame_idx,a.x,a.y\n,inf,5,6\n", "numbered 'inf'"),
        ("track,frame_idx,a.x,a.y\n,1,5\n", "row 2 has 3 columns where 4"),
        ("track,frame_idx,a.x\n,1,5\n", "no node with columns"),
        ("track,frame_idx,a.x,a.y\n", "holds no frame"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table_is_reported_in_one_sentence(
    tmp_path: Path, text: str, words: str
) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    assert words in _sentence(path)


def test_other_files_of_these_programs_are_reported_what_to_export(tmp_path: Path) -> None:
    path = tmp_path / "a.slp"
    path.write_bytes(b"")
    assert "export it as analysis HDF5 or CSV" in _sentence(path)
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["numbers"] = np.arange(3)
    assert "neither SLEAP's analysis nor a table of DeepLabCut" in _sentence(other)
