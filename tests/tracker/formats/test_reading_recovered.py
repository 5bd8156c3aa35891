"""Poses of SMPL as networks recover them from video, in: GVHMR, GEM and WHAM."""

from __future__ import annotations

import io
import pickle
import sys
import tempfile
import types
import zipfile
from collections import OrderedDict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.export.import_motion import fit_to_session
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import parts_in_world
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.smpl import JOINTS, smpl_of
from keypose.tracker.geometry.rotations import Array, log_rotation
from tests.tracker.formats import recordings

SESSION = recordings.session("person")
TRUTH = recordings.trajectory("person")
SKELETON = Skeleton.of(SESSION.subject.body)
TIMES_S = np.arange(len(TRUTH)) / 30
ORIGIN = np.array([0.0, 0.25, -0.03])
"""From the pelvis to the model's own origin, which is what `transl` tells."""


ROTATIONS = smpl_of(SKELETON).motion(parts_in_world(recordings.recording("person"), np.eye(4)))[0]
ROTATIONS = ROTATIONS[:, : len(JOINTS)]
"""(N, 22, 3, 3) of the true motion, the pelvis' in the camera's frame."""


def _params() -> dict[str, Array]:
    """The person's true motion as GVHMR gives it, in the camera's frame."""
    turns = log_rotation(ROTATIONS)
    return {
        "global_orient": turns[:, 0],
        "body_pose": turns[:, 1:].reshape(len(turns), -1),
        "transl": TRUTH.ps_camera_root + ORIGIN,
        "betas": np.zeros((len(turns), 10)),
    }


PARAMS = _params()


def _npz(path: Path, **arrays: Any) -> Path:
    np.savez(path, **arrays)
    return path


def _under(name: str, params: dict[str, Array] = PARAMS) -> dict[str, Array]:
    return {f"{name}.{key}": values for key, values in params.items()}


# --- a file of PyTorch, without PyTorch


class _Storage:
    """A storage's name in a pickle."""


class _Pickler(pickle.Pickler):
    def __init__(self, file: io.BytesIO) -> None:
        super().__init__(file, protocol=2)
        self.stored: list[Array] = []

    def persistent_id(self, obj: Any) -> Any:
        if not isinstance(obj, np.ndarray):
            return None
        self.stored.append(obj)
        kind = sys.modules["torch"].FloatStorage  # type: ignore[attr-defined]
        return ("storage", kind, str(len(self.stored) - 1), "cuda:0", obj.size)


class _Tensor:
    """Pickled as PyTorch pickles one."""

    def __init__(self, values: Array) -> None:
        self.values = values.astype("<f4")

    def __reduce__(self) -> Any:
        made = sys.modules["torch._utils"]._rebuild_tensor_v2  # type: ignore[attr-defined]
        strides = tuple(s // 4 for s in self.values.strides)
        return made, (self.values.ravel(), 0, self.values.shape, strides, False, OrderedDict())


def _stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """PyTorch by the names that its files speak of, for writing them."""

    def _rebuild_tensor_v2() -> None: ...

    torch, utils = types.ModuleType("torch"), types.ModuleType("torch._utils")
    FloatStorage = type("FloatStorage", (_Storage,), {"__module__": "torch"})
    _rebuild_tensor_v2.__module__ = "torch._utils"
    _rebuild_tensor_v2.__qualname__ = "_rebuild_tensor_v2"
    torch.FloatStorage = FloatStorage  # type: ignore[attr-defined]
    utils._rebuild_tensor_v2 = _rebuild_tensor_v2  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "torch", torch)
    monkeypatch.setitem(sys.modules, "torch._utils", utils)


def _pt(path: Path, tree: Any) -> Path:
    content = io.BytesIO()
    pickler = _Pickler(content)
    pickler.dump(tree)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("hmr/data.pkl", content.getvalue())
        for i, values in enumerate(pickler.stored):
            archive.writestr(f"hmr/data/{i}", values.tobytes())
    return path


def plain_pt() -> bytes:
    """A file of PyTorch whose tensors are one each of a motion's parts."""
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        _stand_in(patch)
        return _pt(Path(folder) / "a.pt", {"smpl_params_incam": _tensors(PARAMS)}).read_bytes()


def _tensors(params: dict[str, Array]) -> dict[str, _Tensor]:
    return {key: _Tensor(values) for key, values in params.items()}


# --- what is read


def test_a_motion_in_the_cameras_frame_is_laid_on_the_keyframes(tmp_path: Path) -> None:
    world = {**PARAMS, "transl": PARAMS["transl"] + 5.0}
    arrays = _under("smpl_params_incam") | _under("smpl_params_global", world)
    motion = load_motion(_npz(tmp_path / "gvhmr.npz", **arrays))
    assert (motion.world, motion.unit, motion.is_per_frame) == ("camera", None, True)
    found = fit_to_session(SESSION, motion, "gvhmr.npz", TIMES_S)
    away = found.fit.trajectory.joints(SKELETON) - TRUTH.joints(SKELETON)
    assert np.linalg.norm(away, axis=-1).mean() < 0.02


def test_without_keyframes_it_keeps_its_place_before_the_camera(tmp_path: Path) -> None:
    motion = load_motion(_npz(tmp_path / "gvhmr.npz", **_under("smpl_params_incam")))
    bare = SESSION.changed({"keyframes": ()})
    found = fit_to_session(bare, motion, "gvhmr.npz", TIMES_S)
    place = found.scale * (TRUTH.ps_camera_root + ORIGIN)
    assert np.abs(found.fit.trajectory.ps_camera_root - place).max() < 0.05
    loose = load_motion(_npz(tmp_path / "loose.npz", **PARAMS))
    with pytest.raises(FormatError, match=r"does not say in which frame it is: choose its world"):
        fit_to_session(bare, loose, "loose.npz", TIMES_S)


def test_what_pytorch_wrote_is_read_without_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as there:
        _stand_in(there)
        tree = {"smpl_params_incam": _tensors(PARAMS), "net_outputs": {"model": None, "n": 3}}
        path = _pt(tmp_path / "hmr4d_results.pt", tree)
    found = load_motion(path)
    same = load_motion(_npz(tmp_path / "same.npz", **_under("smpl_params_incam")))
    assert np.allclose(found.ps_world_joint, same.ps_world_joint, atol=1e-5)


def test_wham_shows_which_frames_its_poses_are_of(tmp_path: Path) -> None:
    pose = np.concatenate(
        [PARAMS["global_orient"], PARAMS["body_pose"], np.zeros((len(TRUTH), 6))], 1
    )
    arrays = {"pose": pose[::2], "trans": PARAMS["transl"][::2], "pose_world": pose[::2]}
    frames = np.arange(len(TRUTH))[::2]
    motion = load_motion(_npz(tmp_path / "wham.npz", **arrays, frame_ids=frames))
    assert motion.world == "camera"
    assert len(motion) == frames[-1] + 1
    assert np.isnan(motion.ps_world_joint[1::2]).all()
    with pytest.raises(FormatError, match="frame_ids should ascend"):
        load_motion(_npz(tmp_path / "wham.npz", **arrays, frame_ids=frames[::-1]))


def test_poses_may_be_matrices_and_have_a_batch_of_one(tmp_path: Path) -> None:
    given = {
        "global_orient": ROTATIONS[None, :, :1],
        "body_pose": ROTATIONS[None, :, 1:],
        "transl": PARAMS["transl"],
    }
    found = load_motion(_npz(tmp_path / "a.npz", **_under("body_params_incam", given)))
    same = load_motion(_npz(tmp_path / "b.npz", **_under("smpl_params_incam")))
    assert np.allclose(found.ps_world_joint, same.ps_world_joint, atol=1e-9)


# --- what is not


def test_poses_of_another_film_want_a_rate(tmp_path: Path) -> None:
    motion = load_motion(_npz(tmp_path / "a.npz", **_under("smpl_params_incam")))
    with pytest.raises(
        FormatError, match=r"one for each frame, and the video 30 frames: give the rows' rate"
    ):
        fit_to_session(SESSION, motion, "a.npz", TIMES_S[:30])
    assert not motion.at_rate(60.0).is_per_frame


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"transl": PARAMS["transl"][:5]}, "poses in global_orient and 5 in transl"),
        ({"transl": PARAMS["transl"][:, :2]}, "a place for each pose"),
        ({"transl": PARAMS["transl"] * np.nan}, "else than finite numbers in its transl"),
        ({"body_pose": PARAMS["body_pose"][:, :9]}, "has 3 joints; 21 are expected"),
        ({"body_pose": PARAMS["body_pose"][:, :10]}, "three numbers for each joint"),
        ({"body_pose": np.ones((len(TRUTH), 21, 3, 3))}, "matrices that are no rotations"),
        ({"global_orient": np.array("north")}, "else than finite numbers in its global_orient"),
        ({"global_orient": np.zeros((0, 3))}, "numbers for each pose"),
        ({"body_pose": np.array({"a": 1}, dtype=object)}, "holds objects"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(
    tmp_path: Path, changes: dict[str, Any], words: str
) -> None:
    path = _npz(tmp_path / "a.npz", **_under("smpl_params_incam", {**PARAMS, **changes}))
    with pytest.raises(FormatError, match=words) as caught:
        load_motion(path)
    assert str(caught.value).endswith(".")


class _Runs:
    def __reduce__(self) -> Any:
        return Path.touch, (Path("ran"),)


def test_no_code_within_a_file_is_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = _pt(tmp_path / "a.pt", {"smpl_params_incam": _Runs()})
    with pytest.raises(FormatError, match="which may run code; in Python with PyTorch"):
        load_motion(path)
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(_Runs()))
    with pytest.raises(FormatError, match="may run code when it is read"):
        load_motion(tmp_path / "a.pkl")
    assert not (tmp_path / "ran").exists()


def test_a_tensor_that_claims_more_than_its_numbers_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Larger(_Tensor):
        def __reduce__(self) -> Any:
            made, (values, *_) = super().__reduce__()
            return made, (values, 0, (2**40, 3), (0, 1), False, OrderedDict())

    with monkeypatch.context() as there:
        _stand_in(there)
        path = _pt(tmp_path / "a.pt", {"transl": Larger(np.zeros(3))})
    with pytest.raises(FormatError, match="a tensor"):
        load_motion(path)


def _with_pickle(path: Path, content: bytes) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("hmr/data.pkl", content)
    return path


def test_a_dict_that_holds_itself_is_read_once(tmp_path: Path) -> None:
    within: dict[str, Any] = {}
    within.update({str(n): within for n in range(100)})
    with pytest.raises(FormatError, match="has no global_orient"):
        load_motion(_with_pickle(tmp_path / "a.pt", pickle.dumps(within)))


def test_a_pickle_that_numbers_its_parts_by_the_million_takes_no_memory(tmp_path: Path) -> None:
    memo = b"\x80\x02}r" + (2**20).to_bytes(4, "little") + b"."
    with pytest.raises(FormatError, match="it is damaged"):
        load_motion(_with_pickle(tmp_path / "a.pt", memo))


def test_a_file_cut_short_or_overwritten_is_reported_or_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    short = {key: values[:4] for key, values in PARAMS.items()}
    with monkeypatch.context() as there:
        _stand_in(there)
        pt = _pt(tmp_path / "a.pt", {"smpl_params_incam": _tensors(short)})
    rng = np.random.default_rng(3)
    for path in (pt, _npz(tmp_path / "a.npz", **_under("smpl_params_incam", short))):
        content = path.read_bytes()
        for place in rng.integers(1, len(content), 60):
            change = bytes(rng.integers(0, 256, 3, "u1"))
            for broken in (content[:place], content[:place] + change + content[place + 3 :]):
                path.write_bytes(broken)
                try:
                    load_motion(path)
                except FormatError as error:
                    reported = str(error)
                    assert "\n" not in reported
