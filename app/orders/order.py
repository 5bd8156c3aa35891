"""An option of an order: declared as one field, read from texts, shown on command line and page."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, TypeAlias, TypeVar

from keypose.app.orders.values import Misread, Switch, Value
from keypose.tracker.errors import FormatError

OrderT = TypeVar("OrderT")
Texts: TypeAlias = Mapping[str, str | Sequence[str]]
"""An order as a page sends it: by field the text of its value, several where it may be repeated."""


@dataclass(frozen=True)
class Option:
    """How one field of an order is asked for.

    value: its kind.  words: its help on the command line.  flag: its name there, where it is not
    the field's own; "" where the command line asks for it otherwise.  label: its name in a form of
    the page, "" where forms leave it out; empty: what its field shows while nothing is chosen;
    note: what stands beside it.  repeated: whether it may be given several times, as a tuple.
    group: at most one option of a group may be given.  page: whether a page may say it, which can
    name no files.  only: which formats it matters to, by the flag of `Format` that they have.
    persons: whether all but its first choice need a person's body.  once: whether the command line
    refuses a second one, which would mean another thing and not a change of mind.
    """

    value: Value
    words: str = ""
    flag: str | None = None
    label: str = ""
    empty: str = ""
    note: str = ""
    repeated: bool = False
    group: str | None = None
    page: bool = True
    only: str | None = None
    persons: bool = False
    once: bool = False


def option(value: Value, words: str = "", default: Any = None, **how: Any) -> Any:
    """Declare a field of an order; without it the default holds."""
    return field(default=default, metadata={"option": Option(value, words, **how)})


def options_of(order: type) -> dict[str, Option]:
    """The options of an order by the names of its fields."""
    return {f.name: f.metadata["option"] for f in fields(order) if "option" in f.metadata}


def said_by_page(order: type) -> frozenset[str]:
    """The names of the options that a page may say."""
    return frozenset(name for name, one in options_of(order).items() if one.page)


def read_order(order: type[OrderT], texts: Texts) -> OrderT:
    """Read an order from texts; FormatError, in one sentence, names the option that is wrong."""
    options, values_read = options_of(order), dict[str, Any]()
    for name, text in texts.items():
        if name not in said_by_page(order):
            raise FormatError(f"There is no option {name[:40]!r}.")
        one = options[name]
        try:
            if isinstance(text, str) is one.repeated:
                raise Misread(
                    f"{'several values are' if one.repeated else 'one value is'} expected"
                )
            words = [text] if isinstance(text, str) else text
            values = tuple(one.value.read(word) for word in words)
        except Misread as error:
            raise FormatError(f"{one.label or name}: {str(error).rstrip('.')}.") from None
        values_read[name] = values if one.repeated else values[0]
    require_one_of_each_group(options, values_read, lambda name: options[name].label or name)
    return order(**values_read)


def require_one_of_each_group(
    options: Mapping[str, Option], given: Iterable[str], called: Callable[[str], str]
) -> None:
    """FormatError where two options mean the same; `called` says what a person calls each."""
    chosen: dict[str, str] = {}
    for name in given:
        group = options[name].group
        if group is not None and chosen.setdefault(group, name) != name:
            both = f"{called(chosen[group])} and {called(name)}"
            raise FormatError(f"{both} mean the same; give one of them.")


def form_of(order: type) -> list[dict[str, Any]]:
    """The options that a form of the page shows, with all that it needs to draw them: an
    order's own before those that it shares with others."""
    own = inspect.get_annotations(order)
    options = sorted(options_of(order).items(), key=lambda item: item[0] not in own)
    return [
        {
            "name": name,
            "label": one.label,
            "kind": one.value.form,
            **one.value.shape(),
            **{key: text for key in ("empty", "note", "only") if (text := getattr(one, key))},
            **({"persons": True} if one.persons else {}),
            **({"usual": usual} if (usual := _usual(order, name, one)) else {}),
        }
        for name, one in options
        if one.label
    ]


def _usual(order: type, name: str, one: Option) -> str:
    """The text that stands for the default in a form, "" where nothing is chosen by default."""
    default = next(f.default for f in fields(order) if f.name == name)
    if isinstance(one.value, Switch) or not isinstance(default, str):
        return ""
    return default
