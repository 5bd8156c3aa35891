"""`python -m bench.presets`: write the bodies that come with the product anew."""

from __future__ import annotations

from bench.keeping import ROOT
from bench.presets.animals import DOG, HORSE, make_animal
from bench.presets.people import as_json, make_body
from bench.presets.things import make_objects
from keypose.tracker.body.body import Body
from keypose.tracker.body.preset_names import PEOPLE

FOLDER = ROOT / "tracker" / "body" / "presets"


def bodies() -> tuple[Body, ...]:
    """All of them."""
    return (*map(make_body, PEOPLE), *map(make_animal, (DOG, HORSE)), *make_objects())


def main() -> None:
    """Write a JSON file for each."""
    for body in bodies():
        (FOLDER / f"{body.name}.json").write_text(as_json(body), encoding="utf-8")


if __name__ == "__main__":
    main()
