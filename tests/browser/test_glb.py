"""A GLB file in a real browser: three.js, as viewers on the web use it, loads and plays it."""

from __future__ import annotations

import base64
import zipfile
from collections.abc import Iterator
from importlib import resources
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from keypose.app.render.palette import SIDE_COLOURS, part_sides
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.formats.glb import glb
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import apply_transform, rotation_between
from tests.browser.interaction import PICTURES, SCREENS
from tests.tracker.formats import recordings

SIZE = (640, 360)

STAGE = """
async (file) => {
  const bytes = Uint8Array.from(atob(file), (c) => c.charCodeAt(0)).buffer;
  const loader = new THREE.GLTFLoader();
  const gltf = await new Promise((done, fail) => loader.parse(bytes, '', done, fail));
  const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  renderer.setSize(innerWidth, innerHeight);
  renderer.outputEncoding = THREE.sRGBEncoding;
  document.body.replaceChildren(renderer.domElement);
  document.body.style.margin = 0;
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x303640);
  scene.add(new THREE.AmbientLight(0xffffff, 0.5), new THREE.DirectionalLight(0xffffff, 0.9));
  scene.add(gltf.scene);
  const camera = gltf.cameras[0];
  const mixer = new THREE.AnimationMixer(gltf.scene);
  const action = mixer.clipAction(gltf.animations[0]);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  window.seek = (seconds) => {
    mixer.setTime(seconds);
    scene.updateMatrixWorld(true);
    renderer.render(scene, camera);
  };
  window.place = (name) => {
    const p = gltf.scene.getObjectByName(name).getWorldPosition(new THREE.Vector3());
    return [p.toArray(), p.clone().project(camera).toArray()];
  };
  return { seconds: gltf.animations[0].duration, aspect: camera.aspect };
}
"""


def three_js() -> str:
    """three.js with its loader of glTF, out of trimesh's viewer."""
    packed = resources.files("trimesh").joinpath("resources", "templates", "viewer.zip")
    with packed.open("rb") as file, zipfile.ZipFile(file) as archive:
        page = archive.read("viewer.html.template").decode()
    script = page.split("<script>")[1]
    library, found, _ = script.partition("var camera,controls,scene,renderer")
    assert found, "the viewer is another one now"
    return library


@pytest.fixture(scope="module")
def made() -> Recording:
    return recordings.recording("person")


@pytest.fixture(scope="module")
def stage(browser: Browser, made: Recording) -> Iterator[Page]:
    """The person sample's motion in three.js, seen by the file's own camera."""
    content = glb(made, part_sides(made.skeleton.body), dict(SIDE_COLOURS))
    context = browser.new_context(viewport={"width": SIZE[0], "height": SIZE[1]})
    page = context.new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.add_script_tag(content=three_js())
    reported = page.evaluate(STAGE, base64.b64encode(content).decode())
    assert reported["seconds"] == pytest.approx(made.times_s[-1], abs=1e-5)
    assert reported["aspect"] == pytest.approx(SIZE[0] / SIZE[1], rel=1e-3)
    yield page
    context.close()
    assert not complaints, complaints


def at(made: Recording, seconds: float) -> Any:
    """Ts_camera_part (P, 4, 4) at a time, by our own interpolation."""
    i = int(np.searchsorted(made.times_s, seconds, side="right")) - 1
    share = (seconds - made.times_s[i]) / (made.times_s[i + 1] - made.times_s[i])
    motion = made.trajectory
    Rs = rotation_between(motion.Rs_parent_part[i], motion.Rs_parent_part[i + 1], [share])[0]
    p = motion.ps_camera_root[i] * (1 - share) + motion.ps_camera_root[i + 1] * share
    return part_transforms(made.skeleton, Rs, p)


@pytest.mark.parametrize("seconds", [0.415, 1.7])
def test_between_two_frames_the_hand_is_where_it_should_be(
    stage: Page, made: Recording, seconds: float
) -> None:
    stage.evaluate("(t) => seek(t)", seconds)
    T, T_world_camera = at(made, seconds), made.T_world_camera
    for part in ("left_hand", "right_hand", "left_foot", "head"):
        p_camera = T[made.skeleton.body.index(part), :3, 3]
        place, seen = stage.evaluate("(name) => place(name)", part)
        np.testing.assert_allclose(
            place, apply_transform(T_world_camera, p_camera[None])[0], atol=1e-4
        )
        uv = (np.array(seen[:2]) * [1, -1] + 1) / 2 * SIZE - 0.5
        np.testing.assert_allclose(uv, made.camera.project(p_camera), atol=0.05)


def test_the_body_is_seen_where_the_video_shows_it(stage: Page, made: Recording) -> None:
    pictures = []
    for seconds in (0.415, 1.7):
        stage.evaluate("(t) => seek(t)", seconds)
        content = stage.screenshot()
        if PICTURES:
            SCREENS.mkdir(parents=True, exist_ok=True)
            (SCREENS / f"glb-{seconds}.png").write_bytes(content)
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None
        pictures.append(picture.astype(float))
        body = np.abs(picture.astype(float) - picture[0, 0]).max(axis=2) > 20
        shown = np.argwhere(body)[:, ::-1]
        T = at(made, seconds)
        corners = np.concatenate(
            [
                part.shape.mesh().vertices @ T_camera_part[:3, :3].T + T_camera_part[:3, 3]
                for part, T_camera_part in zip(made.skeleton.body.parts, T, strict=True)
            ]
        )
        uv = made.camera.project(corners)
        np.testing.assert_allclose(shown.min(axis=0), uv.min(axis=0), atol=1.5)
        np.testing.assert_allclose(shown.max(axis=0), uv.max(axis=0), atol=1.5)
    assert np.abs(pictures[0] - pictures[1]).max(axis=2).mean() > 1
    blue, red = (pictures[0][..., k] for k in (0, 2))
    assert (blue > red + 60).sum() > 200  # the left side
    assert (red > blue + 60).sum() > 200  # the right side
