"""The script for Blender, run before a stand-in for it that reads glTF as Blender 5.0 does."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.formats.fbx_script import fbx_script
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.camera_path import CameraPath
from tests.tracker.formats import recordings
from tests.tracker.formats.test_glb import written

FRAMES = 73


class Points:
    """The keys of a curve, their frames and values in turn."""

    def __init__(self, frames: Any, values: Any) -> None:
        self.keys = np.stack([frames, values], axis=1).astype(np.float32).ravel()

    def __len__(self) -> int:
        return len(self.keys) // 2

    def foreach_get(self, name: str, into: Any) -> None:
        assert name == "co"
        into[:] = self.keys

    def foreach_set(self, name: str, keys: Any) -> None:
        assert name == "co"
        self.keys = keys


def blender(made: Recording, layered: bool) -> Any:
    """A stand-in for bpy whose importer brings a camera, where its node is and what it sees."""
    scene = SimpleNamespace(render=SimpleNamespace())
    data = SimpleNamespace(cameras=[], actions=[])
    exported: list[dict[str, Any]] = []

    def opened(**_: Any) -> None:
        down = [made.camera_at(row).height / made.camera_at(row).fy for row in range(len(made))]
        lens = 24.0 / np.array(down)
        data.cameras.append(
            SimpleNamespace(sensor_width=36.0, sensor_height=24.0, lens=lens[0], sensor_fit="AUTO")
        )
        seconds, render = made.times_s, scene.render
        curves = [
            ("location", Points(seconds * render.fps * render.fps_base, np.zeros(len(made)))),
            ("lens", Points(seconds * render.fps, lens)),
        ]
        made_of = [
            SimpleNamespace(data_path=path, keyframe_points=points, update=lambda: None)
            for path, points in curves
        ]
        bag = SimpleNamespace(fcurves=made_of)
        layer = SimpleNamespace(strips=[SimpleNamespace(channelbags=[bag])])
        data.actions.append(SimpleNamespace(layers=[layer]) if layered else bag)

    ops = SimpleNamespace(
        wm=SimpleNamespace(read_factory_settings=lambda **_: None),
        import_scene=SimpleNamespace(gltf=opened),
        export_scene=SimpleNamespace(fbx=lambda **asked: exported.append(asked)),
    )
    context = SimpleNamespace(scene=scene)
    return SimpleNamespace(ops=ops, data=data, context=context, exported=exported)


def run(
    made: Recording, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, layered: bool = True
) -> Any:
    there = blender(made, layered)
    monkeypatch.setitem(sys.modules, "bpy", there)
    exec(fbx_script(made), {"__file__": str(tmp_path / "motion_to_fbx.py")})
    assert len(there.exported) == 1
    return there


def walk(rate: float, size: tuple[int, int] = (640, 360), first: int = 0, zoom: float = 1.0) -> Any:
    """The walk from a frame on, before a camera that zooms."""
    made = recordings.recording("person")
    lens = made.camera.model_copy(update={"width": size[0], "height": size[1]})
    still = CameraPath.standing_still(FRAMES).Ts_camera_world
    path = CameraPath(still, np.linspace(1.0, zoom, FRAMES)) if zoom != 1.0 else None
    times_s = np.arange(FRAMES) / rate
    made = replace(made, camera=lens, times_s=times_s, rate=rate, path=path)
    return made.between(first, FRAMES - 1)


@pytest.mark.parametrize(
    "rate",
    [Fraction(n, d) for n, d in ((30, 1), (25, 1), (30000, 1001), (24000, 1001), (60000, 1001))]
    + [Fraction(99, 8), Fraction(240000, 1001)],
)
@pytest.mark.parametrize("layered", [True, False])
def test_every_key_of_the_fbx_lies_on_a_frame_of_the_film_at_its_rate(
    rate: Fraction, layered: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    made = walk(float(rate), first=12, zoom=1.2)
    there = run(made, monkeypatch, tmp_path, layered)
    (action,) = there.data.actions
    bag = action.layers[0].strips[0].channelbags[0] if layered else action
    for curve in bag.fcurves:
        np.testing.assert_array_equal(curve.keyframe_points.keys[::2], np.arange(12, FRAMES))
    scene = there.context.scene
    assert (scene.frame_start, scene.frame_end) == (12, FRAMES - 1)
    assert scene.render.fps / scene.render.fps_base == pytest.approx(float(rate))
    assert isinstance(scene.render.fps, int)


@pytest.mark.parametrize("size", [(640, 360), (640, 480), (720, 576), (2048, 858), (360, 640)])
@pytest.mark.parametrize("zoom", [1.0, 1.3])
def test_the_camera_of_the_fbx_sees_as_much_across_and_down_as_the_films(
    size: tuple[int, int], zoom: float, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    made = walk(30.0, size, zoom=zoom)
    there = run(made, monkeypatch, tmp_path)
    (camera,), lens = there.data.cameras, made.camera
    assert camera.sensor_fit == "HORIZONTAL"
    across = 2 * math.degrees(math.atan(camera.sensor_width / 2 / camera.lens))
    assert across == pytest.approx(2 * math.degrees(math.atan(lens.width / 2 / lens.fx)))
    aspect = camera.sensor_width / camera.sensor_height
    assert aspect == pytest.approx(size[0] / size[1])
    render = there.context.scene.render
    assert (render.resolution_x, render.resolution_y) == size
    _, zooming = there.data.actions[0].layers[0].strips[0].channelbags[0].fcurves
    last = zooming.keyframe_points.keys[-1]
    assert last == pytest.approx(camera.lens * zoom, rel=1e-6)


def test_the_script_says_the_frames_of_the_glb_beside_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from tests.tracker.formats.glb_reading import Player

    made = walk(30000 / 1001, first=7)
    there = run(made, monkeypatch, tmp_path)
    ends = Player.of(written(made)).times_s[[0, -1]] * 30000 / 1001
    scene = there.context.scene
    assert [scene.frame_start, scene.frame_end] == ends.round(3).tolist()
