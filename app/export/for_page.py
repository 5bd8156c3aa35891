"""Write what the page knows of orders and formats, as a module of its own.

`python -m keypose.app.export.for_page` writes `static/store/orders.js` anew.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from keypose.app.export.motion_formats import FORMATS
from keypose.app.export.recognising import ENDINGS, NOT_OFFERED
from keypose.app.orders.drawing import DRAWN
from keypose.app.orders.imports import IMPORTS
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import form_of

PLACE = Path("store") / "orders.js"
"""Below the folder of the page."""
EXPORTS = {**DRAWN, "motion": MotionOrder}

_HEAD = """\
// What may be ordered and in which formats, written by app/export/for_page.py: change it there.

/**
 * An option of an order: its name there, and what a form has to know to ask for it.
 * @typedef {object} Option
 * @property {string} name
 * @property {string} label
 * @property {string} kind
 * @property {string} [empty]  What its field shows while nothing is chosen.
 * @property {string} [note]
 * @property {string} [usual]
 * @property {string[]} [only]  The formats that it matters to; without it all.
 * @property {boolean} [persons]  All but the first choice need a person's body.
 * @property {number} [least]
 * @property {number | null} [most]
 * @property {string} [unit]
 * @property {{ id: string, label: string, note?: string }[]} [options]
 * @property {string[]} [labels]  Of off and on.
 */

/**
 * A file format of motion.
 * @typedef {object} Format
 * @property {string} label
 * @property {string} icon
 * @property {string} reader  Who reads it.
 * @property {string} also  What it is found by.
 * @property {string} alone
 * @property {string} remark
 * @property {string} then  What a person still does with its files, a sentence.
 * @property {string} needs  A package that has to be installed.
 * @property {boolean} gaps
 * @property {boolean} ownTimes
 */
"""


def module_text() -> str:
    """The whole module."""
    exports = {export: _options(order) for export, order in EXPORTS.items()}
    imports = {kind: _options(order) for kind, order in IMPORTS.items()}
    formats = {name: _format(name) for name in FORMATS}
    names = " | ".join(f"'{name}'" for name in FORMATS)
    endings = [ending for ending in ENDINGS if ending not in NOT_OFFERED]
    return "\n".join(
        (
            _HEAD,
            f"/** @type {{Record<string, Option[]>}} */\nexport const EXPORTS = {_js(exports)};\n",
            f"/** @type {{Record<string, Option[]>}} */\nexport const IMPORTS = {_js(imports)};\n",
            f"/** @typedef {{{names}}} FormatName */\n\n"
            "/** @type {Record<FormatName, Format>} */\n"
            f"export const FORMATS = {_js(formats)};\n",
            "/** Endings of what can be imported. @type {string[]} */\n"
            f"export const ENDINGS = {json.dumps(endings)};\n",
        )
    )


def _options(order: type) -> list[dict[str, Any]]:
    options = form_of(order)
    for option in options:
        if "only" in option:
            option["only"] = [
                name for name, kind in FORMATS.items() if kind.is_changed_by(option["only"])
            ]
    return options


def _format(name: str) -> dict[str, Any]:
    kind = FORMATS[name]
    label = kind.label or name.upper()
    return {
        "label": label,
        "icon": kind.icon,
        "reader": kind.reader,
        "also": f"export motion {kind.search}".strip(),
        "alone": kind.title or f"Export {label}",
        "remark": kind.remark,
        "then": kind.then,
        "needs": "" if kind.library is None else kind.library[0],
        "gaps": kind.gaps,
        "ownTimes": kind.own_times,
    }


def _js(table: dict[str, Any]) -> str:
    """One line an option or a format."""
    lines = ["{"]
    for name, value in table.items():
        if isinstance(value, list):
            rows = "".join(f"\n    {json.dumps(row, ensure_ascii=False)}," for row in value)
            lines.append(f"  {name}: [{rows}{chr(10) + '  ' if rows else ''}],")
        else:
            lines.append(f"  {name}: {json.dumps(value, ensure_ascii=False)},")
    return "\n".join((*lines, "}"))


if __name__ == "__main__":
    place = Path(__file__).parents[2] / "static" / PLACE
    place.write_text(module_text(), encoding="utf-8")
