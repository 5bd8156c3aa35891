"""The files for a model that a person has, and what OpenSim makes of them where it is installed."""

from __future__ import annotations

import io
import runpy
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pandas as pd
import pytest

from keypose.app.export.opensim_files import files_for_model
from keypose.app.orders.motion import AS_TRACKED, MotionOrder
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.recording import MARKER_SETS, MarkerSetName
from tests.app.cli_cases import refused
from tests.tracker.formats import recordings
from tests.tracker.formats.opensim_model import osim

WITH_OPENSIM = pytest.mark.skipif(find_spec("opensim") is None, reason="OpenSim is not installed")


@pytest.fixture
def model(tmp_path: Path) -> Path:
    (tmp_path / "models").mkdir()
    place = tmp_path / "models" / "small.osim"
    place.write_bytes(osim())
    return place


@pytest.fixture
def without_opensim(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("keypose.app.export.opensim_files.find_spec", lambda name: None)


@pytest.mark.usefixtures("without_opensim")
def test_a_model_gets_motion_setups_and_a_word_on_what_to_do(model: Path, tmp_path: Path) -> None:
    made = files_for_model(recordings.recording("person"), AS_TRACKED, model, tmp_path / "out")
    assert sorted(made.files) == ["ik.xml", "markers.xml", "motion.mot", "motion.trc", "scale.xml"]
    assert "small-scaled.osim is made by OpenSim's Scale Tool from scale.xml" in made.words
    setup = ElementTree.fromstring(made.files["scale.xml"])
    assert setup.findtext(".//model_file") == "../models/small.osim"
    assert setup.findtext(".//output_model_file") == "small-scaled.osim"
    rows = made.files["motion.mot"].decode().partition("endheader\n")[2]
    table = pd.read_csv(io.StringIO(rows), sep="\t")
    assert "lumbar_extension" in table.columns  # as this model calls it
    assert 0.7 < table["pelvis_ty"].mean() < 1.2  # above the floor


def test_a_model_that_ends_its_reader_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    harm = tmp_path / "harm.osim"
    harm.write_text("import os; os._exit(0)")
    monkeypatch.setattr("keypose.app.export.opensim_files.read_model", runpy.run_path)
    with pytest.raises(FormatError, match=r"^harm\.osim is damaged"):
        files_for_model(recordings.recording("person"), AS_TRACKED, harm, tmp_path)


@pytest.mark.usefixtures("without_opensim")
@pytest.mark.parametrize("marker_set", MARKER_SETS)
def test_markers_of_the_setups_are_those_of_the_table_and_stand_upright(
    marker_set: str, model: Path, tmp_path: Path
) -> None:
    sampling = MotionOrder(markers="halpe26" if marker_set == "halpe26" else "keypose")
    files = files_for_model(recordings.recording("person"), sampling, model, tmp_path).files
    lines = files["motion.trc"].decode().splitlines()
    names = [cell for cell in lines[3].split("\t")[2:] if cell]
    for setup, tag in (("markers.xml", "Marker"), ("ik.xml", "IKMarkerTask")):
        root = ElementTree.fromstring(files[setup])
        assert [element.get("name") for element in root.iter(tag)] == names
    unit = dict(zip(lines[1].split("\t"), lines[2].split("\t"), strict=True))["Units"]
    heights_m = [float(cell) / {"mm": 1000, "m": 1}[unit] for cell in lines[6].split("\t")[3::3]]
    assert min(heights_m) > -0.06
    assert 1.4 < max(heights_m) < 2.0


@pytest.mark.usefixtures("without_opensim")
@pytest.mark.parametrize(
    ("marker_set", "beside"), [("keypose", []), ("halpe26", ["lumbar_extension"])]
)
def test_where_markers_of_the_pelvis_lie_in_one_line_the_trunks_bend_stays_near_the_motion(
    marker_set: MarkerSetName, beside: list[str], model: Path, tmp_path: Path
) -> None:
    sampling = MotionOrder(markers=marker_set)
    files = files_for_model(recordings.recording("person"), sampling, model, tmp_path).files
    ik = ElementTree.fromstring(files["ik.xml"])
    tasks = list(ik.iter("IKCoordinateTask"))
    assert [task.get("name") for task in tasks] == beside
    assert all(task.findtext("value_type") == "from_file" for task in tasks)
    assert all(0 < float(task.findtext("weight", "")) < 0.01 for task in tasks)  # markers weigh 1
    assert ik.findtext(".//coordinate_file") == ("motion.mot" if beside else None)


def test_gaps_in_the_motion_are_named(model: Path, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="not tracked, and MOT holds no gaps"):
        files_for_model(recordings.recording("person", without=(1,)), AS_TRACKED, model, tmp_path)


def test_the_command_knows_every_set_of_markers_and_no_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["export", "x", "--format", "trc", "--markers", "nobody", "--out", "o"]
    assert f"choose from {', '.join(MARKER_SETS)}" in refused(capsys, tmp_path, command)


@WITH_OPENSIM
def test_opensim_itself_scales_the_model(model: Path, tmp_path: Path) -> None:
    made = files_for_model(recordings.recording("person"), AS_TRACKED, model, tmp_path / "out")
    assert "small-scaled.osim is the model at the body's size" in made.words
    (tmp_path / "scaled.osim").write_bytes(made.files["small-scaled.osim"])
    reported = subprocess.run(
        [sys.executable, "-c", "import opensim; m = opensim.Model('scaled.osim'); "
         "m.initSystem(); print('markers', m.getMarkerSet().getSize())"],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    count = len(list(ElementTree.fromstring(made.files["markers.xml"]).iter("Marker")))
    assert f"markers {count}" in reported.stdout
    assert not list(Path.cwd().glob("opensim.log"))
