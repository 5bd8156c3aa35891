"""The renderer against its own promises: what other tests rely on."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.geometry.rotations import apply_transform
from keypose.tracker.geometry.view import ViewCamera
from tests.rendering.scenes import Scene, scene
from tests.rendering.settings import Occluder, RenderSettings

CLEAN = RenderSettings(noise=0.0)


def small(name: str = "stride", frames: int = 3, settings: RenderSettings = CLEAN) -> Scene:
    return scene(name, settings, size=(320, 180)).cut(40, 40 + frames - 1)


def changed(base: Scene, **changes: object) -> NDArray[np.uint8]:
    return replace(base, settings=replace(base.settings, **changes)).frames()


def test_the_same_seed_gives_the_same_frames_and_another_seed_others() -> None:
    noisy = small(settings=RenderSettings(noise=3.0, flicker=0.1))
    frames = noisy.frames()
    assert frames.shape == (3, 180, 320, 3)
    assert frames.dtype == np.uint8
    np.testing.assert_array_equal(frames, noisy.frames())
    assert (frames != changed(noisy, seed=1)).mean() > 0.5


@pytest.mark.parametrize("projection", ["perspective", "telephoto"])
def test_the_truth_carries_each_surface_point_to_where_it_is_next(projection: str) -> None:
    base = scene("tumbling_box", replace(CLEAN, ambient=1.0), size=(480, 360)).cut(10, 11)
    if projection == "telephoto":
        update = {"projection": projection, "telephoto_distance_m": 3.0}
        base = replace(base, camera=base.camera.model_copy(update=update))
    first, second = (frame.astype(np.float32) for frame in base.frames())
    T = base.truth.transforms(base.skeleton)
    view, mesh = ViewCamera.of(base.camera), BodyMesh.of(base.skeleton)
    seen, later = raster(mesh, T[0], view), raster(mesh, T[1], view)
    inner = cv2.erode((seen.part >= 0).astype(np.uint8), np.ones((9, 9))) > 0
    rows, columns = np.nonzero(inner)
    uv = np.column_stack([columns, rows]).astype(float)
    p_eye = view.back_project(uv, seen.depth[inner].astype(float))
    moved = apply_transform(T[1, 0] @ np.linalg.inv(T[0, 0]), p_eye)
    to = view.project(moved).astype(np.float32)
    shown = later.face[tuple(np.rint(to[:, ::-1]).astype(int).T)] == seen.face[inner]
    carried = cv2.remap(second, to[None, :, 0], to[None, :, 1], cv2.INTER_LINEAR)[0]
    miss = np.abs(carried - first[inner])[shown].mean()
    stay = np.abs(second[inner] - first[inner])[shown].mean()
    assert shown.sum() > 3000
    assert miss < 0.25 * stay
    assert miss < 3.0


def test_the_body_stands_where_the_camera_projects_it() -> None:
    base = small(frames=1)
    bare = replace(base.settings, background_contrast=0.0)
    frame = replace(base, settings=bare).frames()[0].astype(int)
    mask = raster(
        BodyMesh.of(base.skeleton),
        base.truth.transforms(base.skeleton)[0],
        ViewCamera.of(base.camera),
    ).part
    outside = cv2.dilate((mask >= 0).astype(np.uint8), np.ones((3, 3))) == 0
    differs = np.abs(frame - np.median(frame, axis=1, keepdims=True)).max(axis=2) > 2
    assert not differs[outside].any()
    assert differs[mask >= 0].mean() > 0.9


def test_a_texture_poor_body_has_less_contrast_than_a_textured_one() -> None:
    base = small(frames=1)
    rich, poor = base.frames()[0], changed(base, texture_contrast=4.0)[0]
    skeleton, T = base.skeleton, base.truth.transforms(base.skeleton)[0]
    chest = raster(
        BodyMesh.of(skeleton), T, ViewCamera.of(base.camera)
    ).part == skeleton.body.index("chest")
    assert rich[chest].std(axis=0).mean() > 1.5 * poor[chest].std(axis=0).mean()


def test_the_background_pans_by_whole_and_broken_pixels() -> None:
    base = small("speech", frames=3)
    still, panned = base.frames(), changed(base, pan_px_per_frame=2.5)
    np.testing.assert_array_equal(still[0], panned[0])
    np.testing.assert_array_equal(panned[2][:, :60], still[2][:, 5:65])
    between = (panned[1][:, :60].astype(float) - still[1][:, 2:62] * 0.5) * 2 - still[1][:, 3:63]
    assert np.abs(between).max() <= 3.0


def test_ramp_and_flicker_change_the_gain_from_frame_to_frame() -> None:
    base = small("speech", frames=8)
    plain = base.frames().astype(float).mean(axis=(1, 2, 3))
    ramped = changed(base, illumination_ramp=0.2).astype(float).mean(axis=(1, 2, 3))
    np.testing.assert_allclose(ramped / plain, np.linspace(1.0, 1.2, 8), atol=0.01)
    flickering = changed(base, flicker=0.1).astype(float).mean(axis=(1, 2, 3)) / plain
    assert 0.03 < np.ptp(flickering) < 0.21


def test_noise_has_the_deviation_asked_for() -> None:
    base = small(frames=1)
    difference = changed(base, noise=6.0)[0].astype(float) - base.frames()[0]
    assert difference.std() == pytest.approx(6.0, rel=0.03)


def test_a_bar_hides_what_is_behind_it() -> None:
    base = small(frames=1)
    frame = changed(base, occluder=Occluder(left_px=150.0, width_px=20.0))[0]
    assert (frame[:, 151:169] == frame[:1, 151:169]).all()
    np.testing.assert_array_equal(frame[:, :149], base.frames()[0][:, :149])


def test_motion_blur_is_centred_on_the_truth() -> None:
    base = small("tumbling_box", frames=3)
    sharp = base.frames().astype(float)
    blurred = changed(base, shutter=0.8, sub_frames=7)[1].astype(float)
    before, at, after = (np.abs(blurred - picture).mean() for picture in sharp)
    assert 0.05 < at < 0.6 * min(before, after)
    assert before == pytest.approx(after, rel=0.25)
