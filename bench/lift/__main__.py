"""`python -m bench.lift train|export|measure`: see README.md beside this file."""

from __future__ import annotations

import argparse
from pathlib import Path


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.lift", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    train = commands.add_parser("train", help="train two networks on one core")
    train.add_argument("capture", type=Path, help="mocap_30hz.npz")
    train.add_argument("out", type=Path, help="file of weights to write, .npz")
    train.add_argument("--minutes", type=float, default=45.0)
    train.add_argument("--steps", type=int, default=0, help="in place of minutes")
    train.add_argument("--start", type=Path, help="weights to begin with")
    export = commands.add_parser("export", help="write the ONNX file of weights")
    export.add_argument("weights", type=Path)
    export.add_argument("out", type=Path)
    measure = commands.add_parser("measure", help="print figures of the network in the package")
    measure.add_argument("--capture", type=Path, help="mocap_30hz.npz")
    measure.add_argument(
        "--film",
        nargs=2,
        type=Path,
        action="append",
        default=[],
        metavar=("CLIP", "SESSION"),
        help="a folder with a film and markers, and what `keypose draft` wrote of the film",
    )
    given = parser.parse_args()
    # each needs packages that others do not
    if given.command == "train":
        from bench.lift.train import Plan
        from bench.lift.train import train as trained

        plan = Plan(minutes=given.minutes, steps=given.steps)
        trained(given.capture, given.out, plan, given.start)
    elif given.command == "export":
        from bench.lift.export import export as exported
        from bench.lift.train import load

        print(exported(load(given.weights), given.out))
    else:
        from bench.lift.measure import measure as measured

        measured(given.capture, [(clip, session) for clip, session in given.film])


if __name__ == "__main__":
    main()
