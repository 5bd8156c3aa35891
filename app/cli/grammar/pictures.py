"""Grammar of the commands that draw: pictures, films, sheets, the report."""

from __future__ import annotations

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_order,
    add_output,
    add_session,
    typed,
)
from keypose.app.orders.bodies import EachBody, OneBody
from keypose.app.orders.drawing import FilmOrder, MatteOrder, PictureOrder, SheetOrder
from keypose.app.orders.values import Whole

_SHOT_EXAMPLES = """\
  keypose shot session.json --frame 40 --view main --out frame40.png
  keypose shot session.json --frame 40 --view all --style wire --out views.png --overwrite
  keypose shot session.json --frame 40 --view orbit:60,20 --size 1920x1080 --out corner.png
  keypose shot session.json --frame 40 --background none --scale 2 --out body.png
"""


def add_shot(commands: Subcommands) -> None:
    details = (
        "Uses the keyframe's pose if there is one at this frame, else the tracked pose. Views:"
        " main is the undistorted video frame with the body over it (grey if the frame is "
        "missing); orbit looks at the body from any side, with a floor: an azimuth of 0 looks "
        "along the video's camera, 90 from the right of its picture; the default elevation is "
        "12 degrees. An observed surface is drawn behind the body in main and around it in "
        "every other view."
    )
    command = add_command(commands, "shot", details, _SHOT_EXAMPLES)
    add_session(command)
    add_order(command, EachBody)
    command.add_argument(
        "--frame", metavar="N", type=typed(Whole(least=0)), required=True, help="the frame to draw"
    )
    add_order(command, PictureOrder)
    add_output(command, "FILE.png")


_FILM_EXAMPLES = """\
  keypose film session.json --out overlay.mp4
  keypose film session.json --view orbit --size 1280x720 --out round.mp4
  keypose film session.json --view camera:120,15 --frames 10-60 --out batter.mp4
  keypose film session.json --view all --fps 10 --out slowly.mp4 --overwrite
"""


def add_film(commands: Subcommands) -> None:
    details = (
        "Views: main draws the body over the video; all adds the top, side and front views; "
        "orbit circles the body once while it moves; camera is a fixed viewpoint at an azimuth"
        " and an elevation. An azimuth of 0 looks along the video's camera, 90 from the right "
        "of its picture. Frames keep their times; frames without a pose are shown without the "
        "body. An observed surface is shown in every view."
    )
    command = add_command(commands, "film", details, _FILM_EXAMPLES)
    add_session(command)
    add_order(command, EachBody)
    add_order(command, FilmOrder)
    add_output(command, "FILE.mp4")


_SHEET_EXAMPLES = """\
  keypose sheet session.json --out keyframes.png
  keypose sheet session.json --columns 4 --style wire --out keyframes.png --overwrite
"""


def add_sheet(commands: Subcommands) -> None:
    details = (
        "Each picture is labelled with its frame, its time and the number of frames to the "
        "next keyframe. The bar below has the colour of that segment's verdict: green good, "
        "yellow check, red lost, grey not tracked or outdated."
    )
    command = add_command(commands, "sheet", details, _SHEET_EXAMPLES)
    add_session(command)
    add_order(command, OneBody)
    add_order(command, SheetOrder)
    add_output(command, "FILE.png")


_MATTE_EXAMPLES = """\
  keypose matte session.json --out matte
  keypose matte session.json --frames 10-60 --kind mov --out person.mov
  keypose matte session.json --alpha-only --out alpha --overwrite
"""


def add_matte(commands: Subcommands) -> None:
    details = (
        "A network shows in every frame where the person is; it starts at the keyframes, or "
        "where the poses were drafted. Pictures are RGBA of the frame as it was filmed, alpha "
        "straight. Frames without the person have an empty alpha, and their number is said, as is "
        "where it may be another person, after two have crossed."
    )
    command = add_command(commands, "matte", details, _MATTE_EXAMPLES)
    add_session(command)
    add_order(command, OneBody)
    add_order(command, MatteOrder)
    add_output(command, "PLACE", "the folder of the pictures, or the film's file")


_REPORT_EXAMPLES = """\
  keypose report session.json --out report.html
  keypose report session.json --out report.html --overwrite
"""


def add_report(commands: Subcommands) -> None:
    details = (
        "It has the verdicts in words, rank and observability over time, the error of every "
        "pass, joint angles, the gait of one who walks, keyframes with their intervals, and "
        "pictures. The file is self-contained and needs no network. Without the video the "
        "pictures are left out."
    )
    command = add_command(commands, "report", details, _REPORT_EXAMPLES)
    add_session(command)
    add_order(command, EachBody)
    add_output(command, "FILE.html")
