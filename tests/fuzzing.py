"""Files of every kind that Keypose reads, and seeded mutants of them."""

from __future__ import annotations

import hashlib
import io
import json
import random
import re
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose import sample_videos
from keypose.app.document.defaults import read_defaults
from keypose.app.export.import_camera import camera_motion_of
from keypose.tracker.body.body import load_body
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError
from keypose.tracker.formats.camera_files import camera_json, chan
from keypose.tracker.formats.cameras.placing import FilmFrames, placed
from keypose.tracker.formats.joint_names import load_names
from keypose.tracker.formats.marker_files import c3d
from keypose.tracker.formats.opensim.model import read_model
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.reading_camera import load_camera
from keypose.tracker.formats.reading_keypoints import load_keypoints
from keypose.tracker.formats.reference import load_reference
from keypose.tracker.keypoints.model_files import added_folder, find_model
from keypose.tracker.keypoints.recognise_network import promised
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.networks import add_own
from keypose.tracker.surface.cameras.rig import Rig
from tests.tracker.formats import animals, recordings
from tests.tracker.formats import test_reconstructed_cameras as reconstructed
from tests.tracker.formats.opensim_model import osim
from tests.tracker.formats.test_camera_files import WIDE, tilted
from tests.tracker.formats.test_glb import written
from tests.tracker.formats.test_moving_camera_files import moving
from tests.tracker.formats.test_reading_camera import gltf
from tests.tracker.formats.test_reading_motion import BVH, CSV, TRC
from tests.tracker.formats.test_reading_recovered import PARAMS, plain_pt
from tests.tracker.keypoints import tiny_networks as tiny

SAMPLES = Path(sample_videos.__file__).parent
SKELETON = Skeleton.of(recordings.session("person").subject.body)
LONGEST_SENTENCE = 800
NUMBERS = (
    *("nan", "inf", "-inf", "1e999", "-1", "0", "-0.0", "1e-320", "1.5", "", "²", "٣", "0x10"),
    *("9" * 5000, "1e308", "-1e308", "9" * 18, "true", "null"),
)
VALUES: tuple[Any, ...] = (
    *(None, True, -1, 0, 1.5, 10**400, 10**18, 1e308, -1e308, float("nan"), "", "²", "x" * 5000),
    *([], {}, [[]], [None], {"": None}, "9" * 5000, "\ud800", "a\nb", [1e308] * 4),
)


@dataclass(frozen=True)
class Kind:
    """One kind of file: its name, what is in a sound one, and what reads it."""

    file: str
    content: bytes
    read: Callable[[Path], object]
    apart: bool = False
    """Its library may end the process: it is read in a child, or not at all."""


def _camera(path: Path) -> object:
    """A camera, in frames of a film where it moves."""
    found = load_camera(path, (WIDE.width, WIDE.height))
    film = FilmFrames(np.arange(40) / 30)
    return (
        found
        if found.way is None
        else camera_motion_of(placed(path.name, found.way, film)[0], len(film), path.name)
    )


def _reference(path: Path) -> object:
    return load_reference(path, SKELETON)


def _defaults(path: Path) -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KEYPOSE_CONFIG", str(path))
        return read_defaults()


def _network(path: Path) -> object:
    return promised(path.read_bytes(), repr(str(path)))


def _own_network(path: Path) -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(path.parent))
        return add_own("mine", path, hashlib.sha256(path.read_bytes()).hexdigest())


def _added_network(path: Path) -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(path.parent))
        added_folder().mkdir(parents=True, exist_ok=True)
        (added_folder() / path.name).write_bytes(path.read_bytes())
        return find_model(path.stem)


def _zipped(name: str, content: bytes) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return whole.getvalue()


def _json(value: Any) -> bytes:
    return json.dumps(value).encode()


def _npz(**arrays: Any) -> bytes:
    content = io.BytesIO()
    np.savez(content, **arrays)
    return content.getvalue()


def kinds(folder: Path) -> dict[str, Kind]:
    """All of them, by name. folder: where those are made that are written to a path."""
    names, uv = ("nose", "left_ear"), np.random.default_rng(1).uniform(20, 300, (1, 6, 2, 2))
    columns, values = animals.dlc_columns(names), animals.dlc_values(uv)
    motion = recordings.trajectory("person")
    person = [float(n) for n in range(51)]
    landmarks = [{"x": 0.1, "y": 0.2, "visibility": 0.9}] * 33
    coco = [{"image_id": n, "keypoints": person} for n in range(3)]
    poses = {"first_frame": 0, "Rs_parent_part": motion.Rs_parent_part}
    rig = {"name": "a", "R_camera_world": np.eye(3).tolist(), "t_camera_world": [0, 0, 3]}
    openpose = {"people": [{"pose_keypoints_2d": person + person[:24]}]}
    mediapipe = {"frames": [{"landmarks": landmarks}], "info": {"width": 9, "height": 9, "fps": 25}}
    sleap = animals.sleap_csv(folder / "s.csv", names, uv).read_bytes()
    deeplabcut = animals.dlc_csv(folder / "d.csv", columns, values).read_bytes()
    hdf5 = animals.sleap_h5(folder / "s.h5", names, uv).read_bytes()
    session = (SAMPLES / "person/session.json").read_bytes()
    defaults = b'port = 8090\nbody = "adult_female"\nbrowser = true\n'
    lens = WIDE.model_dump(include={"width", "height", "fx", "fy", "cx", "cy"})
    cameras = {"units": "m", "up": "+y", "cameras": [{**rig, **lens}]}
    network = _zipped("a/end2end.onnx", tiny.maps())
    heads = {"kind": "maps", "layout": "COCO_17", "width": 192, "height": 256, "outputs": ["a"]}
    own = {"name": "own", "sha256": "0" * 64, "size_mb": 1.5, "heads": heads}
    return {
        "BVH": Kind("a.bvh", BVH.encode(), load_motion),
        "TRC": Kind("a.trc", TRC.encode(), load_motion),
        "table": Kind("a.csv", CSV.encode(), load_motion),
        "SMPL": Kind("a.npz", _npz(**{f"smpl.{k}": v for k, v in PARAMS.items()}), load_motion),
        "PyTorch": Kind("a.pt", plain_pt(), load_motion),
        "COCO": Kind("c.json", _json(coco), load_keypoints),
        "OpenPose": Kind("o.json", _json(openpose), load_keypoints),
        "MediaPipe": Kind("m.json", _json(mediapipe), load_keypoints),
        "SLEAP": Kind("s.csv", sleap, load_keypoints),
        "DeepLabCut": Kind("d.csv", deeplabcut, load_keypoints),
        "HDF5": Kind("s.h5", hdf5, load_keypoints, apart=True),
        "camera": Kind("k.json", camera_json(tilted()).encode(), _camera),
        "chan": Kind("k.chan", chan(tilted()).encode(), _camera),
        "GLB": Kind("k.glb", written(tilted()), _camera),
        "glTF": Kind("k.gltf", _json(gltf()), _camera),
        "moving camera": Kind("k.json", camera_json(moving()).encode(), _camera),
        "moving chan": Kind("k.chan", chan(moving()).encode(), _camera),
        "moving GLB": Kind("k.glb", written(moving()), _camera),
        "transforms": Kind("t.json", reconstructed.transforms().encode(), _camera),
        "splats": Kind("t.json", reconstructed.splats().encode(), _camera),
        "COLMAP": Kind("images.txt", reconstructed.images().encode(), _camera),
        "TUM": Kind("tum.txt", reconstructed.tum().encode(), _camera),
        "poses": Kind("r.npz", _npz(**poses, ps_camera_root=motion.ps_camera_root), _reference),
        "marks": Kind("r.json", _json({"frames": {"3": {"LShoulder": [5, 6.5]}}}), _reference),
        "OpenSim": Kind("m.osim", osim(), read_model),
        "names": Kind("n.json", _json({"theirs": "ours"}), load_names),
        "rig": Kind("rig.json", _json(cameras), Rig.open),
        "body": Kind("b.json", (SAMPLES / "bodies/box.json").read_bytes(), load_body),
        "session": Kind("session.json", session, load_session),
        "defaults": Kind("config.toml", defaults, _defaults),
        "network": Kind("n.onnx", tiny.maps(), _network),
        "network in a zip": Kind("n.zip", network, _own_network, apart=True),
        "added network": Kind("own.json", _json(own), _added_network),
        "C3D": Kind("a.c3d", c3d(recordings.recording("person")), load_motion, apart=True),
    }  # fmt: skip


def mutant(kind: Kind, seed: int) -> bytes:
    """A file of that kind with something wrong, the same for the same seed."""
    chance = random.Random(f"{kind.file} {seed}")
    content = kind.content
    if content.startswith(b"PK"):
        return _repacked(content, chance)
    if kind.file.endswith((".json", ".gltf")) and chance.random() < 0.7:
        return _json(_other_value(json.loads(content), chance))
    return _bytes(content, chance)


def _bytes(content: bytes, chance: random.Random) -> bytes:
    """A number in it exchanged, or some of its bytes."""
    for _ in range(chance.randint(1, 3)):
        numbers = list(re.finditer(rb"[-+]?\d[\d.]*", content[:20_000]))
        place, length = chance.randrange(len(content) + 1), chance.randint(0, 9)
        match chance.randrange(6):
            case 0 | 1 | 2 if numbers:
                start, end = chance.choice(numbers).span()
                content = content[:start] + chance.choice(NUMBERS).encode() + content[end:]
            case 3:
                content = content[:place]
            case 4:
                content = content[:place] + content[place + length :]
            case _:
                content = content[:place] + chance.randbytes(length) + content[place + length :]
    return content


def _repacked(content: bytes, chance: random.Random) -> bytes:
    """An archive with one of its entries changed; a whole one, or the change would be its end."""
    if chance.random() < 0.2:
        return _bytes(content, chance)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    name = chance.choice(sorted(entries))
    entries[name] = _bytes(entries[name], chance)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for entry, held in entries.items():
            archive.writestr(entry, held)
    return packed.getvalue()


def _other_value(tree: Any, chance: random.Random) -> Any:
    """The tree with one value, or one name, in it exchanged."""
    places = list(_places(tree))
    if not places:
        return chance.choice(VALUES)
    holder, key = chance.choice(places)
    if isinstance(holder, dict) and chance.random() < 0.2:
        holder[chance.choice(("", "x" * 5000, "9" * 5000, "-1", "²"))] = holder.pop(key)
    elif chance.random() < 0.1:
        del holder[key]
    else:
        holder[key] = chance.choice(VALUES)
    return tree


def _places(tree: Any) -> Any:
    if isinstance(tree, dict | list):
        for key, value in list(tree.items() if isinstance(tree, dict) else enumerate(tree)):
            yield tree, key
            yield from _places(value)


def fault(kind: Kind, path: Path, read: Callable[[Path], object] | None = None) -> str | None:
    """What is wrong with how a file is read; None where it is read, or refused in a sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            (read or kind.read)(path)
    except KeyposeError as refused:
        words = str(refused)
        if len(words) > LONGEST_SENTENCE or "\n" in words:
            return f"{len(words)} characters: {words[:200]!r}"
    except Exception as error:  # noqa: BLE001 — what is looked for
        return f"{type(error).__name__}: {str(error)[:200]}"
    return None
