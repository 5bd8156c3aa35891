"""An order is the same by whatever door it comes: command line, page or batch."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from keypose.app.cli.arguments import add_order, order_of
from keypose.app.cli.main import grammar
from keypose.app.export.for_page import EXPORTS, PLACE, module_text
from keypose.app.orders.drawing import PictureOrder, Seen
from keypose.app.orders.imports import IMPORTS
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import Option, options_of, read_order
from keypose.app.orders.values import (
    Choice,
    FrameRange,
    Frames,
    Name,
    Number,
    Percent,
    Pixels,
    Rate,
    Switch,
    Whole,
)
from keypose.tracker.errors import FormatError

STATIC = Path(__file__).parents[3] / "static"
GOOD = {
    Number: "6", Whole: "3", Percent: "40", Rate: "29.97", Name: "dog", FrameRange: "3-40",
    Frames: "48,0,24", Pixels: "320x240", Seen: "camera:30,10",
}  # fmt: skip
OPTIONS = [
    (order, name, one)
    for order in (*EXPORTS.values(), PictureOrder, *IMPORTS.values())
    for name, one in options_of(order).items()
    if one.flag != "" and one.page
]
CASES = pytest.mark.parametrize(
    ("order", "name", "one"),
    OPTIONS,
    ids=[f"{order.__name__}-{name}" for order, name, _ in OPTIONS],
)


def text_of(one: Option) -> str:
    if isinstance(one.value, Choice):
        return one.value.names[1]
    return GOOD.get(type(one.value), "tailtip=tail.end")


def by_command_line(order: type, name: str, one: Option, text: str) -> object:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_order(parser, order)
    flag = f"--{one.flag or name.replace('_', '-')}"
    words = [flag] if isinstance(one.value, Switch) else [flag, text]
    return order_of(order, parser.parse_args(words))


def by_page(order: type, name: str, one: Option, text: str) -> object:
    text = "true" if isinstance(one.value, Switch) else text
    return read_order(order, {name: [text] if one.repeated else text})


@CASES
def test_an_option_means_the_same_by_every_door(order: type, name: str, one: Option) -> None:
    made = by_command_line(order, name, one, text_of(one))
    assert made == by_page(order, name, one, text_of(one))
    assert made != order()


@CASES
def test_what_an_option_cannot_be_is_refused_in_the_same_words(
    order: type, name: str, one: Option
) -> None:
    if isinstance(one.value, Switch):
        return
    wrong = "" if isinstance(one.value, Name) else "nonsense"
    with pytest.raises(argparse.ArgumentError) as refused:
        by_command_line(order, name, one, wrong)
    words = refused.value.message
    with pytest.raises(FormatError) as told:
        by_page(order, name, one, wrong)
    assert str(told.value) == f"{one.label or name}: {words}."


def test_a_batch_exports_with_every_option_of_an_export() -> None:
    commands = grammar()[1]
    asked = {
        f"--{one.flag or name.replace('_', '-')}" for name, one in options_of(MotionOrder).items()
    }
    assert asked <= set(commands["batch"].options()) & set(commands["export"].options())


@pytest.mark.parametrize(
    ("order", "texts", "words"),
    [
        ("motion", {"out": "/etc"}, "There is no option 'out'."),
        ("motion", {"fps": ["1"]}, "Rate: one value is expected."),
        ("pictures", {"size": "64x64", "scale": "2"}, "Size and scale mean the same"),
        ("film", {"frames": "9-3"}, "Frames: '9-3' are no frames such as 10-60."),
    ],
)
def test_what_no_order_can_be_is_refused(order: str, texts: dict[str, str], words: str) -> None:
    with pytest.raises(FormatError, match=words):
        read_order(EXPORTS[order], texts)


def test_a_page_names_no_file_of_this_computer() -> None:
    with pytest.raises(FormatError, match="no option 'names'"):
        read_order(IMPORTS["motion"], {"names": "/etc/passwd"})


def test_the_page_knows_every_order_and_format() -> None:
    written = (STATIC / PLACE).read_text("utf-8")
    assert written == module_text(), "python -m keypose.app.export.for_page"
