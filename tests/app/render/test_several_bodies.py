"""Pictures of several bodies: the one that is posed in its sides' colours, others in one each."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any, Final

import cv2
import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.export.report import report
from keypose.app.export.report.subject import Subject, subject_of
from keypose.app.render.painting import (
    Figure,
    cut_out,
    cut_out_figures,
    form_in,
    form_of,
    paint_figures,
)
from keypose.app.render.palette import BODY_COLOURS, body_colour
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.storage.files import load_session, save_session
from tests.app.bodies_cases import of_two
from tests.app.render import test_pictures as cases
from tests.scenes import sample

TOLD_APART: Final = 24.0
"""Between colours in CIELAB: ten times what an eye just sees side by side."""
SHEET = np.full((cases.CAMERA.height, cases.CAMERA.width, 3), 90, dtype=np.uint8)
VIEW = ViewCamera.of(cases.CAMERA)


def figure(forward_m: float) -> Figure:
    Ts = pose_transforms(cases.SKELETON, cases.posed())
    Ts[:, 2, 3] += forward_m
    return Figure(form_in(cases.SKELETON, body_colour(1)), Ts)


def test_the_nearest_body_hides_the_others_whichever_is_named_first() -> None:
    near, far, own = figure(-0.4), figure(0.8), figure(0.0)
    own = replace(own, form=form_of(cases.SKELETON))
    pictures = [
        paint_figures(SHEET, VIEW, order, "solid", 1.0) for order in permutations((near, far, own))
    ]
    for each in pictures[1:]:
        np.testing.assert_array_equal(each, pictures[0])
    alone = paint_figures(SHEET, VIEW, [near], "solid", 1.0)
    covered = (alone != SHEET).any(axis=2).astype(np.uint8)
    inside = cv2.erode(covered, np.ones((5, 5), np.uint8)) > 0
    assert inside.sum() > 200
    np.testing.assert_array_equal(pictures[0][inside], alone[inside])


def test_alone_it_is_cut_out_as_always_and_with_another_more_is_covered() -> None:
    own, far = figure(0.0), figure(0.8)
    alone = cut_out(VIEW, own.form, own.Ts_camera_part, "both", 0.5)
    np.testing.assert_array_equal(cut_out_figures(VIEW, [own], "both", 0.5), alone)
    both = cut_out_figures(VIEW, [own, far], "both", 0.5)
    assert (both[..., 3] >= alone[..., 3]).all()
    assert (both[..., 3] > alone[..., 3]).any()


@pytest.mark.parametrize("view", ["main", "side", "all", "orbit:30"])
@pytest.mark.parametrize("background", ["video", "none"])
def test_a_picture_shows_all_bodies_unless_one_is_asked_for(
    view: str, background: str, tmp_path: Path
) -> None:
    path = with_a_second_body(tmp_path)
    drawn = ["shot", str(path), "--frame", "0", "--view", view, "--background", background]
    drawn += ["--style", "solid", "--opacity", "100"] if view in ("main", "all") else []
    pictures = {}
    for name, asked in {"all": [], "one": ["--body", "body"]}.items():
        out = tmp_path / f"{name}.png"
        assert main([*drawn, *asked, "--out", str(out)]) == 0
        pictures[name] = cv2.imread(str(out))
    assert _has(pictures["all"])
    assert not _has(pictures["one"])


def with_a_second_body(folder: Path) -> Path:
    path = sample(folder, "box")
    session = of_two(load_session(path))
    aside = session.bodies[1].keyframes[0].model_copy(update={"root_m": (0.3, 0.1, 2.5)})
    second = session.bodies[1].model_copy(update={"keyframes": (aside,)})
    save_session(session.with_body(second), path)
    return path


def test_a_sheet_shows_all_bodies(tmp_path: Path) -> None:
    path, out = with_a_second_body(tmp_path), tmp_path / "sheet.png"
    drawn = ["--style", "solid", "--opacity", "100", "--out", str(out)]
    assert main(["sheet", str(path), *drawn]) == 0
    assert _has(cv2.imread(str(out)))


@pytest.mark.parametrize(("asked", "shown"), [((), True), (("--body", "body"), False)])
def test_a_report_shows_all_bodies_unless_one_is_asked_for(
    asked: tuple[str, ...], shown: bool, tmp_path: Path
) -> None:
    path, out = with_a_second_body(tmp_path), tmp_path / "report.html"
    assert main(["report", str(path), *asked, "--out", str(out)]) == 0
    jpegs = re.findall(r'src="data:image/jpeg;base64,([^"]+)" [^>]*alt="Frame 0', out.read_text())
    assert jpegs
    content = np.frombuffer(base64.b64decode(jpegs[0]), np.uint8)
    assert _has(cv2.imdecode(content, cv2.IMREAD_COLOR)) is shown


def test_a_report_judges_each_body_with_the_keypoints_that_are_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, judged = with_a_second_body(tmp_path), {}
    said = KeypointCorrection(frame=0, joint="left_wrist", uv=(20.0, 20.0))
    second = load_session(path).about("second").changed({"keypoint_corrections": (said,)})
    save_session(second.about("body"), path)

    def subject_seen(session: Session, *place: Any, **named: Any) -> Subject:
        judged[session.subject.id] = session.view.keypoint_corrections
        return subject_of(session, *place, **named)

    monkeypatch.setattr(report, "subject_of", subject_seen)
    for asked in ((), ("--body", "second")):
        out = tmp_path / f"{len(asked)}.html"
        assert main(["report", str(path), *asked, "--out", str(out)]) == 0
        assert judged.pop("second") == (said,)


def _has(picture: np.ndarray) -> bool:
    """Whether the second body's pink is on it: much more red than green, shaded or not."""
    blue, green, red = (picture[..., k].astype(int) for k in range(3))
    return bool(((red - green > 50) & (blue - green > 20)).sum() > 100)


def test_ten_bodies_have_colours_that_can_be_told_apart() -> None:
    colours = [body_colour(place) for place in range(10)]
    assert len(BODY_COLOURS) == 10
    rgb = np.array([colours], dtype=np.float32) / 255
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB)[0]
    apart = np.linalg.norm(lab[:, None] - lab, axis=-1)
    assert apart[~np.eye(10, dtype=bool)].min() > TOLD_APART
