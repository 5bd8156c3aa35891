"""Word what standing on the floor changed, and how the soles lie on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from keypose.app.posing.labels import part_label
from keypose.app.words.camera import way_sentences
from keypose.app.words.problems import frame_range, named_frames
from keypose.app.words.up import apart_words, up_words

if TYPE_CHECKING:
    from keypose.tracker.operations.stand import Standing
    from keypose.tracker.session.pins import Pin
    from keypose.tracker.space.harm import Harm
    from keypose.tracker.space.soles import Soles

T = TypeVar("T")
MOST_NAMED: Final = 3
"""Places that are named one by one."""


def standing_words(done: Standing, *, beside: bool = False) -> str:
    """Such as "12 pins on the floor, 10 of them new; 9 keyframes give way in depth.".

    beside: whether it stands on the floor of another body, of which what is up was said.
    """
    pins = _count(done.on_floor, "pin")
    new = f", {done.taken} of them new" if done.taken else ""
    soft = len(done.softened)
    gives = f"; {_count(soft, 'keyframe')} {'gives' if soft == 1 else 'give'} way in depth"
    words = [f"{pins} on the floor{new}{gives if soft else ''}."]
    words += [] if beside else _up_sentences(done)
    words += [f"{_named(pin)} stands higher and was left there." for pin in _some(done.raised)]
    motion = done.session.view.camera_motion
    words += way_sentences(motion) if motion is not None and done.scaled else []
    for first, last in _some(done.unscaled):
        frames = named_frames(first, last)
        words.append(f"The scale of the camera's path is not known in {frames}: no pins there.")
    return " ".join([*words, *_pin_words(done)])


def _up_sentences(done: Standing) -> list[str]:
    """What is up, what it rests on, and by how much feet turned it."""
    words = []
    if not done.session.has_up_of_hand:
        words.append(up_words(done.up))
    elif done.up.apart:
        words.append(f"{apart_words(done.up)} Check the horizon.")
    if round(np.degrees(done.tilted_rad)):
        turned = f"{np.degrees(done.tilted_rad):.0f}°"
        words.append(f"Up was turned by {turned}, to where feet stand level.")
    return words


def _pin_words(done: Standing) -> list[str]:
    """What pins would have done that were not set, what those do that are, and feet in the air."""
    words = [
        f"{_named(harm.pin)} is not pinned: that would {_does(harm)}."
        for harm in _some(done.released)
    ]
    more = len(done.released) - MOST_NAMED
    words += [f"{_count(more, 'more stance')} not pinned either."] if more > 0 else []
    much = sorted((harm for harm in done.harms if harm.is_much), key=lambda harm: -harm.share)
    words += [f"{_named(h.pin)} is pinned: check it, it may {_does(h)}." for h in _some(much)]
    words += [
        f"{_named(pin)} is still and {100 * high:.0f} cm above the floor: pin it if it stands."
        for pin, high in _some(done.hanging)
    ]
    px = max((harm.amount for harm in done.harms if harm.kind == "picture"), default=0.0)
    bent = max((harm.amount for harm in done.harms if harm.kind == "knee"), default=0.0)
    return [*words, f"Legs moved by up to {px:.0f} px, knees by up to {np.degrees(bent):.0f}°."]


def _does(harm: Harm) -> str:
    """Such as "move the left foot by 9 px", or "bend the knee by 12°"."""
    if harm.kind == "knee":
        return f"bend the knee by {np.degrees(harm.amount):.0f}°"
    return f"move the {part_label(harm.part).lower()} by {harm.amount:.0f} px"


def _named(pin: Pin) -> str:
    """Such as "Left foot, frames 3–9,"."""
    return f"{part_label(pin.part)}, {named_frames(*pin.span)},"


def _some(items: Sequence[T]) -> Sequence[T]:
    return items[:MOST_NAMED]


def lifted_words(drafts: int, keyframes: int) -> str:
    """Such as "280 drafts and 6 keyframes were found anew"."""
    keyed = f" and {_count(keyframes, 'keyframe')}" if keyframes else ""
    was = "was" if drafts + keyframes == 1 else "were"
    return f"{_count(drafts, 'draft')}{keyed} {was} found anew."


def soles_words(soles: Soles) -> str:
    """Such as "Soles within 1.1 cm of the floor. In the air: 141, 150–156"."""
    words = f"Soles within {100 * abs(soles.off_m):.1f} cm of the floor."
    if not soles.in_air:
        return words
    runs = ", ".join(frame_range(*run) for run in soles.in_air[:MOST_NAMED])
    more = len(soles.in_air) - MOST_NAMED
    return f"{words} In the air: {runs}{f' and {more} more' if more > 0 else ''}."


def _count(number: int, word: str) -> str:
    return f"{number} {word}{'' if number == 1 else 's'}"


def bodies_stand_words(
    standing: Mapping[str, Standing],
    refused: Mapping[str, str],
    names: Mapping[str, str],
    along: Sequence[str] = (),
) -> str:
    """What standing did, of each of several bodies by its name; why some do not stand, and which
    things go along."""
    things = [along_words(names[body_id]) for body_id in along]
    if len(standing) + len(refused) == 1:
        ((_, done),) = standing.items()
        return " ".join([standing_words(done), *things])
    stand = [
        f"{names[body_id]}: {standing_words(done, beside=place > 0)}"
        for place, (body_id, done) in enumerate(standing.items())
    ]
    floor_of = names[next(iter(standing))]
    not_standing = [
        f"{names[body_id]}: {refused_words(why, floor_of)}" for body_id, why in refused.items()
    ]
    return " ".join([*stand, *not_standing, *things])


def refused_words(why: str, floor_of: str) -> str:
    """Why a body does not stand on the floor of another one."""
    return f"{why} It was not stood on the floor of {floor_of}."


def along_words(name: str) -> str:
    """A thing that is held goes along with who was stood."""
    return f"{name} goes along with the hand that holds it: its keyframes give way in depth."
