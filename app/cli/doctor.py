"""`keypose doctor`: what of this computer Keypose needs, whether it is there, and what to do."""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import sys
import tempfile
import webbrowser
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Final, Literal, TypeAlias

from keypose.app.cli.exit_codes import DONE, NOT_ALL_DONE
from keypose.app.cli.json_output import print_json
from keypose.app.export.motion_formats import FORMATS
from keypose.tracker.errors import KeyposeError

State: TypeAlias = Literal["ok", "note", "warning", "error"]

FEW_GB: Final = 4.0
"""Of memory: two films' clips and what decodes them."""
LITTLE_GB: Final = 1.0
"""Of disk space."""
REINSTALL: Final = "Install Keypose again, as its README says."
LIBRARIES: Final = (
    ("numpy", "numpy"),
    ("scipy", "scipy"),
    ("cv2", "opencv-python-headless"),
    ("av", "av"),
    ("numba", "numba"),
    ("viser", "viser"),
    ("starlette", "starlette"),
    ("uvicorn", "uvicorn"),
)
EXTRAS: Final = (
    *(
        (kind.library[1], kind.library[0], f"motion in {name.upper()} files")
        for name, kind in FORMATS.items()
        if kind.library is not None
    ),
    ("ai_edge_litert", "ai-edge-litert", "BlazePose in less than half the time"),
    ("onnxruntime", "onnxruntime", "other networks of keypoints in less than half the time"),
    ("distributed", "distributed", "`keypose batch` on many computers"),
)


@dataclass(frozen=True)
class Finding:
    """What one check found.

    state: error where Keypose cannot work so, warning where a part of it cannot, note where there
        is a choice.
    remedy: what to do; empty where nothing need be done.
    """

    name: str
    state: State
    words: str
    remedy: str = ""


def examine(workspace: Path | None = None) -> Iterator[Finding]:
    """All checks in turn. A check that breaks is an error that is found, too.

    workspace: instead of the usual one.
    """
    checks: tuple[Callable[[], Iterator[Finding]], ...] = (
        versions,
        libraries,
        page,
        films,
        cores_and_memory,
        lambda: folders(workspace),
        compiled_loops,
        networks,
        port,
        browser,
        extras,
    )
    for check in checks:
        try:
            yield from check()
        except KeyposeError as error:
            yield Finding(_name(check), "error", str(error), "Correct that and try again.")
        except Exception as error:  # noqa: BLE001 — the next check may still say why
            words = f"cannot be checked: {type(error).__name__}: {error}"
            yield Finding(_name(check), "error", words, REINSTALL)


def _name(check: Callable[[], Iterator[Finding]]) -> str:
    name = getattr(check, "__name__", "")
    return "folders" if name == "<lambda>" else name.replace("_", " ")


def versions() -> Iterator[Finding]:
    try:
        own = version("keypose")
    except PackageNotFoundError:
        own = "not installed"
    python = f"Python {platform.python_version()}"
    yield Finding("Keypose", "ok", f"{own}, {python}, {platform.system()} {platform.machine()}")


def libraries() -> Iterator[Finding]:
    here = []
    for module, package in LIBRARIES:
        try:
            import_module(module)
        except (ImportError, OSError, RuntimeError) as error:
            words = f"{package} cannot be loaded: {error}"
            yield Finding("libraries", "error", words, REINSTALL)
        else:
            here.append(f"{package} {version(package)}")
    if here:
        yield Finding("libraries", "ok", ", ".join(here))


def page() -> Iterator[Finding]:
    from keypose.app.document.library.library import SAMPLE_FOLDER
    from keypose.app.document.library.samples import bundled_samples
    from keypose.app.scene.viser_compat import PAGE
    from keypose.app.server.server import STATIC

    files = (STATIC / "index.html", STATIC / "page.js", PAGE)
    missing = [path for path in files if not path.is_file()]
    if missing:
        yield Finding("page", "error", f"{missing[0]} is missing", REINSTALL)
        return
    samples = len(bundled_samples(SAMPLE_FOLDER))
    yield Finding("page", "ok", f"its files are here, and {samples} samples")


def films() -> Iterator[Finding]:
    import numpy as np

    from keypose.tracker.video import Video
    from keypose.tracker.video.encode import FilmWriter, can_write_films

    if not can_write_films():
        words = "films cannot be written, for PyAV has no H.264 encoder; reading is not affected"
        yield Finding("video", "warning", words, REINSTALL)
        return
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "film.mp4"
        with FilmWriter(place, (64, 48), Fraction(1, 25), Fraction(25)) as film:
            for frame in range(3):
                film.add(np.full((48, 64, 3), 80 * frame, np.uint8), frame)
        with Video.open(place) as video:
            is_right = abs(float(video.frame(2).mean()) - 160.0) < 8.0
    if is_right:
        yield Finding("video", "ok", "H.264 is written and read")
    else:
        words = "H.264 that was written is read with other colours"
        yield Finding("video", "error", words, REINSTALL)


def cores_and_memory() -> Iterator[Finding]:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield Finding("cores", "ok", f"{cores or 'an unknown number'}")
    memory_gb = _memory_gb()
    if memory_gb is None:
        return
    words = f"{memory_gb:.1f} GB"
    if memory_gb < FEW_GB:
        remedy = "Close other programs; track shorter clips, or with --quality preview."
        yield Finding("memory", "warning", f"{words}, which long clips may fill", remedy)
    else:
        yield Finding("memory", "ok", words)


def _memory_gb() -> float | None:
    """The computer's memory; None where the system does not say so."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    except (AttributeError, OSError, ValueError):
        return None


def folders(workspace: Path | None = None) -> Iterator[Finding]:
    from keypose.app.document.defaults import defaults_path, read_defaults
    from keypose.tracker.keypoints.model_files import cache_folder

    path = defaults_path()
    is_there = path.exists()
    yield Finding("defaults", "ok", str(path) if is_there else f"built in; {path} is not there")
    place = workspace or read_defaults().workspace
    remedy = f"Name another one with --workspace, or in {path}."
    yield _folder("workspace", place, "error", remedy)
    remedy = "Make it writable, or set XDG_CACHE_HOME to a folder that is."
    yield _folder("cache", cache_folder(), "warning", remedy)


def _folder(name: str, folder: Path, state: State, remedy: str) -> Finding:
    """Whether it, or the nearest folder above that exists, can be written to."""
    nearest = next(p for p in (folder, *folder.absolute().parents) if p.exists())
    try:
        with tempfile.TemporaryFile(dir=nearest) as probe:
            probe.write(bytes(2**20))  # where the disk or a quota is full, a file can still be made
    except OSError as error:
        words = f"{folder} cannot be written to: {error.strerror or error}"
        return Finding(name, state, words, remedy)
    free_gb = shutil.disk_usage(nearest).free / 1e9
    words = f"{folder}, {free_gb:.1f} GB free"
    if free_gb < LITTLE_GB:
        return Finding(name, "warning", words, "Make room on that disk.")
    return Finding(name, "ok", words)


def compiled_loops() -> Iterator[Finding]:
    from keypose.tracker.kernels import FOLDER
    from keypose.tracker.keypoints.model_files import cache_folder
    from keypose.tracker.warm import is_warm

    place, usual = FOLDER.path, cache_folder() / "kernels"
    if is_warm():
        yield Finding("compiled loops", "ok", str(place))
    elif FOLDER.problem:
        words = f"{FOLDER.problem}, so they are compiled at every start, a minute each"
        remedy = "Make room there, or set XDG_CACHE_HOME to another folder of yours."
        yield Finding("compiled loops", "warning", words, remedy)
    else:
        words = "not all compiled yet: the first tracking takes up to half a minute longer"
        yield Finding("compiled loops", "note", words)
    older = [folder for folder in usual.glob("*") if folder.is_dir() and folder != place]
    if older:
        words = f"{len(older)} of other versions take {_megabytes(older)} MB in {usual}"
        yield Finding("compiled loops", "note", words, "They may be deleted; none is needed.")


def _megabytes(of: list[Path]) -> int:
    sizes = (p.stat().st_size for folder in of for p in folder.rglob("*") if p.is_file())
    return round(sum(sizes) / 1e6)


def networks() -> Iterator[Finding]:
    from keypose.tracker.keypoints.detectors import open_detector
    from keypose.tracker.keypoints.model_files import THUNDER

    open_detector(THUNDER)
    yield Finding("keypoints", "ok", "the bundled networks are here and can be read")


def port() -> Iterator[Finding]:
    from keypose.app.document.defaults import read_defaults
    from keypose.app.server.addresses import bind

    number = read_defaults().port
    try:
        bind("127.0.0.1", number).close()
    except KeyposeError:
        words = f"{number} is taken, maybe by another Keypose; the next free one is used"
        yield Finding("port", "note", words, "Another one: keypose open --port N")
    else:
        yield Finding("port", "ok", f"{number} is free")


def browser() -> Iterator[Finding]:
    try:
        default_browser = webbrowser.get()
    except webbrowser.Error:
        default_browser = None
    if default_browser is None or type(default_browser) is webbrowser.GenericBrowser:
        words = "none that can be opened from here"
        remedy = "Open the link that `keypose open` prints, in a browser with WebGL."
        yield Finding("browser", "note", words, remedy)
    else:
        yield Finding("browser", "ok", getattr(default_browser, "name", "") or "the system's")


def extras() -> Iterator[Finding]:
    for module, package, purpose in EXTRAS:
        if find_spec(module) is not None:
            yield Finding(package, "ok", f"installed: {purpose}")
        else:
            yield Finding(package, "note", f"not installed: {purpose}", _adding(package))


def _adding(package: str) -> str:
    """The command that adds a package to where Keypose is installed."""
    if Path(sys.prefix, "pipx_metadata.json").is_file():
        return f"pipx inject keypose {package}"
    if Path(sys.prefix, "uv-receipt.toml").is_file():
        return f"Install Keypose again by uv tool install, with --with {package}"
    return f"{sys.executable} -m pip install {package}"


_MARKS = {"ok": "ok", "note": "note", "warning": "warning", "error": "ERROR"}


def run(arguments: argparse.Namespace) -> int:
    findings = []
    for finding in examine(arguments.workspace):
        findings.append(finding)
        if not arguments.json:
            _print(finding)
    is_well = all(finding.state != "error" for finding in findings)
    if arguments.json:
        print_json({"well": is_well, "findings": [asdict(finding) for finding in findings]})
    else:
        print(_summary(findings))
    return DONE if is_well else NOT_ALL_DONE


def _print(finding: Finding) -> None:
    print(f"{_MARKS[finding.state]:8}{finding.name}: {finding.words}")
    if finding.remedy:
        print(f"{'':8}  {finding.remedy}")
    sys.stdout.flush()


def _summary(findings: list[Finding]) -> str:
    count = Counter(finding.state for finding in findings)
    if count["error"]:
        return f"Keypose cannot work here yet: see the {count['error']} marked ERROR."
    if count["warning"]:
        return f"Keypose works here, with {count['warning']} limited: see what is marked warning."
    return "Keypose works here."
