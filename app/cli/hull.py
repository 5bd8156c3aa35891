"""`keypose hull`: surfaces from what calibrated cameras took."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, TypeAlias

from keypose.app.cli.arguments import (
    note,
)
from keypose.app.cli.exit_codes import DONE, INTERRUPTED, NOT_ALL_DONE
from keypose.app.cli.json_output import print_json
from keypose.app.cli.long_work import set_when_interrupted, warm_hull_kernels
from keypose.tracker.errors import SurfaceError, numbers_listed
from keypose.tracker.keypoints.blazepose import BlazePose
from keypose.tracker.storage.atomic import make_folder, require_absent, require_folder, write_file
from keypose.tracker.surface.cameras.hulls import Hulls, ply_bytes
from keypose.tracker.surface.cameras.rig import Rig

OnStep: TypeAlias = Callable[[int, str], None]
"""Receives a step that is done, and its outcome."""


def run(arguments: argparse.Namespace) -> int:
    out: Path = arguments.out
    stop = threading.Event()
    with ExitStack() as stack:
        rig, network = Rig.open(arguments.rig), BlazePose.open() if arguments.person else None
        hulls = stack.enter_context(Hulls(rig, arguments.voxel, network))
        places = [out / f"step_{step:04d}.ply" for step in range(hulls.step_count)]
        if not arguments.overwrite:
            require_absent(places, error=SurfaceError)
        require_folder(out, error=SurfaceError)
        make_folder(out, error=SurfaceError)
        if not hulls.has_images:
            note(
                "The cameras' file names no images: the surfaces do not say which of their "
                "parts are reliable."
            )
        warm_hull_kernels()
        stack.enter_context(set_when_interrupted(stop))
        written, refused = _make(hulls, places, stop, arguments)
    _print_outcome(written, refused, hulls, stop.is_set(), arguments)
    if stop.is_set():
        return INTERRUPTED
    return NOT_ALL_DONE if refused else DONE


def _make(
    hulls: Hulls, places: list[Path], stop: threading.Event, arguments: argparse.Namespace
) -> tuple[list[Path], dict[int, str]]:
    """The files written, and why others are not."""
    written: list[Path] = []
    refused: dict[int, str] = {}
    with _progress(len(places), arguments.json) as on_step:
        for step, place in enumerate(places):
            if stop.is_set():
                break
            try:
                mesh = hulls.mesh(step)
            except SurfaceError as error:
                refused[step] = str(error)
                if arguments.overwrite:
                    place.unlink(missing_ok=True)  # of another run: it is not this step's any more
                on_step(step, "left out")
                continue
            content = ply_bytes(mesh)
            write_file(place, content, overwrite=arguments.overwrite, error=SurfaceError)
            written.append(place)
            on_step(step, f"{len(mesh.faces):,} faces")
    if refused and not written:
        raise SurfaceError(next(iter(refused.values())))
    return written, refused


@contextmanager
def _progress(count: int, as_json: bool) -> Iterator[OnStep]:
    """Show at a terminal how far it is and how long it will take; else print a quiet line for each
    step, for logs, unless what is written is for a program.
    """
    if sys.stderr.isatty():
        from tqdm import tqdm

        with tqdm(total=count, unit="step", file=sys.stderr, dynamic_ncols=True) as bar:

            def count_on(_step: int, _words: str) -> None:
                bar.update()

            yield count_on
    elif as_json:
        yield lambda step, words: None
    else:
        yield lambda step, words: print(
            f"step {step}, {step + 1} of {count}: {words}", file=sys.stderr, flush=True
        )


def _print_outcome(
    written: list[Path],
    refused: dict[int, str],
    hulls: Hulls,
    interrupted: bool,
    arguments: argparse.Namespace,
) -> None:
    count, left_out = hulls.step_count, sorted(hulls.left_out.items())
    if arguments.json:
        facts: dict[str, Any] = {"written": [str(place) for place in written]}
        steps = [{"step": step, "error": why} for step, why in refused.items()]
        without = {"left_out": {name: sorted(numbers) for name, numbers in left_out}}
        facts |= {"steps": count, "refused": steps, **without, "interrupted": interrupted}
        print_json(facts)
        return
    if written:
        print(f"Written: {written[0]} to {written[-1].name}, {len(written)} of {count} surfaces.")
    for step, why in refused.items():
        note(f"step {step} is left out. {why}")
    for name, numbers in left_out:
        nobody = "shows nobody or " if arguments.person else ""
        note(
            f"camera {name!r} is left out at step {numbers_listed(numbers)}: its picture "
            f"{nobody}cannot be read."
        )
    if interrupted:
        print(f"Interrupted: {len(written)} of {count} steps are kept.", file=sys.stderr)
