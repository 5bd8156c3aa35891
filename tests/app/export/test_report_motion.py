"""What a report says of a person's joints and steps, and the same by files."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from keypose.app.cli.main import main
from keypose.app.editor.known import KnownMotion
from keypose.app.editor.state import EditorState
from keypose.app.export.motion_files import motion_archive
from keypose.app.export.report.gait import clinical_charts, gait_section
from keypose.app.export.report.report import report_html, subject_of
from keypose.app.export.report.subject import Subject, recording_of
from keypose.app.posing import opening_pose
from keypose.tracker.formats.recording import Recording
from keypose.tracker.session.pins import Pin
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.results import Results
from keypose.tracker.storage.tracks import save_result
from tests.app.export.test_report import read
from tests.app.walking_cases import FRAMES, SKELETON, write_walk
from tests.tracker import session_cases as cases
from tests.tracker.formats.recordings import with_depth


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Results]:
    return write_walk(tmp_path_factory.mktemp("report") / "walk")


@pytest.fixture(scope="module")
def subject(walk: tuple[Path, Results]) -> Subject:
    path, _ = walk
    session = load_session(path)
    with open_video_of(session, path) as video:
        return subject_of(session, path, video.info)


@pytest.fixture(scope="module")
def recording(subject: Subject) -> Recording:
    found = recording_of(subject)
    assert found is not None
    return found


def test_every_joint_that_moves_has_a_chart_for_each_plane(
    subject: Subject, recording: Recording
) -> None:
    charts = [read(chart) for chart in clinical_charts(subject, recording)]
    assert len(charts) % 3 == 0
    message = "\n".join(chart.text for chart in charts)
    for words in (
        "Hip flexion − extension", "Hip adduction − abduction",
        "Hip internal rotation − external rotation", "Knee flexion − extension",
        "Trunk rotation to the left − to the right", "Elbow pronation − supination",
    ):  # fmt: skip
        assert words in message
    assert "Wrist" not in message  # hands do not move here


def test_both_sides_are_in_one_chart_with_the_highest_and_lowest_angle(
    subject: Subject, recording: Recording
) -> None:
    charts = clinical_charts(subject, recording)
    (knee,) = [chart for chart in charts if "<b>Knee flexion</b>" in chart]
    knees = [one for one in recording.joint_angles if one.joint.name.endswith("knee")]
    most = max(float(one["flexion"].max()) for one in knees)
    assert f">{most:.0f}°</i>" in knee
    assert knee.count('class="curve left"') == knee.count('class="curve right"') == 1


def test_a_curve_has_a_band_of_what_it_is_expected_to_be_off_by_and_is_grey_where_it_is_a_guess(
    subject: Subject, recording: Recording
) -> None:
    charts = clinical_charts(subject, with_depth(recording, px=0.05, along_m=0.02))
    (knee,) = [chart for chart in charts if "<b>Knee flexion</b>" in chart]
    assert knee.count('class="band left"') == knee.count('class="band right"') == 1
    assert "curve guess" not in knee
    (turned,) = [chart for chart in charts if "<b>Elbow pronation</b>" in chart]
    assert "curve guess" in turned  # which no keypoint shows
    (plain,) = [c for c in clinical_charts(subject, recording) if "<b>Knee flexion</b>" in c]
    assert "band" not in plain


def test_the_gait_of_a_walk_is_in_the_report_with_its_means(
    subject: Subject, recording: Recording
) -> None:
    section = gait_section(subject, recording)
    assert section is not None
    found = read(section)
    assert "as they were found standing" in found.text
    assert "Heel strikes Toe off Time, s Length, m Step length, m" in found.text
    rows = re.findall(r"<tr><th[^>]*><span[^>]*>(Left|Right)</span>(.*?)</tr>", section)
    strides = [cells for _, cells in rows if "mean of" not in cells]
    assert len(strides) >= 3
    for cells in strides:
        first, last = (int(n) for n in re.findall(r"(\d+) → (\d+)", cells)[0])
        assert last - first in (50, 51, 52)  # of the walk's own period
        time_s = float(re.findall(r'"num">([\d.]+)<', cells)[1])
        times_s = recording.times_s
        assert time_s == pytest.approx(times_s[last] - times_s[first], abs=0.006)
    assert section.count("mean of") == 2
    assert section.count('class="curve left"') == 3  # hip, knee and ankle over the cycle


def test_pinned_feet_stand_as_pinned(subject: Subject, recording: Recording) -> None:
    sole = {side: (f"{side}_heel", f"{side}_toe") for side in ("left", "right")}
    pins = tuple(
        Pin(part=f"{side}_foot", landmarks=sole[side], first_frame=a, last_frame=a + 25)
        for side, a in (("left", 43), ("right", 69), ("left", 94))
    )
    section = gait_section(subject, replace(recording, pins=pins))
    assert section is not None
    assert "as pinned" in section
    assert "still 43–68" in section


def test_the_whole_report_has_both_and_the_parts_own_turns_folded(
    walk: tuple[Path, Results],
) -> None:
    path, _ = walk
    session = load_session(path)
    with open_video_of(session, path) as video:
        found = read(report_html(session, path, video))
    for words in ("Joint angles", "Grood and Suntay", "Gait", "Zeni et al. 2008", "stride length"):
        assert words in found.text
    assert "details" in [tag for tag, _ in found.tags]
    assert "Each part's turns in its parent's frame" in found.text


def test_a_body_that_is_no_person_has_the_turns_of_its_parts(session_path: Path) -> None:
    session = load_session(session_path)
    save_session(save_result(session, session_path, cases.result()), session_path)
    with open_video_of(session, session_path) as video:
        text = read(report_html(load_session(session_path), session_path, video)).text
    assert "Each part's turns in its parent's frame" in text
    assert "Grood" not in text
    assert "Zeni" not in text


def test_page_and_command_line_write_the_same_coordinates_and_angles(
    walk: tuple[Path, Results], tmp_path: Path
) -> None:
    path, results = walk
    session = load_session(path)
    with open_video_of(session, path) as video:
        times_s = video.info.times_s
    opening = opening_pose(session.subject.body, session.view.camera, (0.0, -1.0, 0.0))
    edit = EditorState(session, SKELETON, times_s, opening, KnownMotion(results))
    assert main(["export", str(path), "--format", "mot,csv", "--out", str(tmp_path)]) == 0
    assert motion_archive("mot", edit).content == (tmp_path / "motion.mot").read_bytes()
    rows = (tmp_path / "motion.mot").read_text("utf-8").partition("endheader\n")[2]
    of_mot = pd.read_csv(io.StringIO(rows), sep="\t")
    of_csv = pd.read_csv(tmp_path / "angles.csv")
    assert len(of_mot) == len(of_csv) == FRAMES
    for mot, csv in (
        ("knee_angle_r", "right_knee_flexion_deg"), ("hip_flexion_l", "left_hip_flexion_deg"),
        ("arm_add_r", "right_shoulder_adduction_deg"), ("elbow_flex_l", "left_elbow_flexion_deg"),
        ("pelvis_rotation", "pelvis_rotation_deg"),
    ):  # fmt: skip
        np.testing.assert_allclose(of_mot[mot], of_csv[csv], atol=1e-6)
