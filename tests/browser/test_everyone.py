"""The page for everyone: read aloud, by keyboard alone, in forced colours, without motion."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from tests.app.serving import ROOT, Keypose
from tests.browser.interaction import (
    answered,
    between,
    faded,
    screen,
    section,
    settled,
    spot,
    themed,
    until,
    until_counted,
    until_state,
)
from tests.browser.random_states import RandomStates
from tests.browser.shared import Desk, admit, desk, opened
from tests.browser.test_guide import button, title
from tests.browser.test_lens import new_film

AXE = ROOT / "tests" / "page" / "node_modules" / "axe-core" / "axe.min.js"
SET_UP = (Path(__file__).parent / "steady.js").read_text()
SIZE = (1440, 900)

COLOURS = ["color-contrast", "link-in-text-block"]
"""The rules of axe that look at colours."""

RUN_AXE = """async (rules) => {
  const options = { resultTypes: ['violations'], iframes: false };
  if (rules) options.runOnly = rules;
  const { violations } = await axe.run(document, options);
  const said = ({ any, all, none }) => [...any, ...all, ...none][0]?.message;
  return violations.flatMap(({ id, nodes }) => nodes.map((node) =>
    `${id}: ${node.html.replace(/<!--.*?-->/g, '').slice(0, 160)} (${said(node)})`));
}"""


@pytest.fixture(scope="module")
def axe() -> str:
    """What finds where a page cannot be read aloud, or seen by everyone."""
    if not AXE.exists() and os.environ.get("CI"):
        pytest.fail("axe-core is not installed, and a build machine must test with it.")
    if not AXE.exists():
        pytest.skip("axe-core is not installed: npm ci --prefix tests/page.")
    return AXE.read_text()


@pytest.fixture(scope="module")
def shared(browser: Browser, tmp_path_factory: pytest.TempPathFactory, axe: str) -> Iterator[Desk]:
    with desk(browser, tmp_path_factory.mktemp("everyone"), size=SIZE) as made:
        made.page.evaluate(axe)
        made.page.evaluate(SET_UP)
        yield made


def complaints(page: Page) -> list[str]:
    """Of axe, in both themes, which differ in nothing but colours."""
    found: list[str] = []
    for theme, rules in (("light", None), ("dark", COLOURS)):
        themed(page, theme)
        faded(page)
        found += [f"{theme}: {problem}" for problem in page.evaluate(RUN_AXE, rules)]
    return found


def tab(name: str) -> Callable[[Desk], None]:
    return lambda at: at.page.get_by_role("tab", name=name, exact=True).click()


def menu(name: str) -> Callable[[Desk], None]:
    return lambda at: at.page.locator(f"[data-menu={name}] button").last.click()


def key(name: str) -> Callable[[Desk], None]:
    return lambda at: at.page.keyboard.press(name)


def menu_of_a_part(at: Desk) -> None:
    at.page.mouse.click(*spot(at.page, "left_foot"), button="right")
    at.page.locator(".tmenu").wait_for()


def menu_of_the_timeline(at: Desk) -> None:
    box = at.page.locator("#tsvg").bounding_box()
    assert box is not None
    at.page.mouse.click(box["x"] + 400, box["y"] + 35, button="right")
    at.page.locator(".tmenu").wait_for()


def list_of_choices(at: Desk) -> None:
    tab("Track")(at)
    at.page.locator("drop-down .drop").first.click()
    at.page.locator(".drop-list:popover-open").wait_for()


def running(at: Desk) -> None:
    states = RandomStates(at.page, 3)
    for _ in range(4):
        at.page.evaluate("(news) => window.steady.feed(news)", states.next())


def job_that_runs(at: Desk) -> None:
    at.page.evaluate("(news) => window.steady.feed(news)", at_work(at.page))
    at.page.get_by_role("button", name="Cancel").wait_for()


def selected(at: Desk) -> None:
    at.visitor.do(do="select", part="left_foot")
    at.agreed("view")


STATES: dict[str, Callable[[Desk], None]] = {
    "the Part tab": tab("Part"),
    "the Body tab": tab("Body"),
    "the Camera tab": tab("Camera"),
    "the Track tab": tab("Track"),
    "a selected foot": selected,
    "the Sizes tool": key("s"),
    "the menu of files": menu("file"),
    "the menu of tracking": menu("track"),
    "the menu of exports": menu("export"),
    "the menu of themes": menu("theme"),
    "a part's menu": menu_of_a_part,
    "the timeline's menu": menu_of_the_timeline,
    "a list of choices": list_of_choices,
    "the sheet of keys": key("?"),
    "four views": key("5"),
    "the free view": key("6"),
    "job and messages": running,
    "a job that runs": job_that_runs,
}


@pytest.mark.parametrize("name", list(STATES))
def test_axe_finds_nothing_in(shared: Desk, axe: str, name: str) -> None:
    shared.fresh()
    STATES[name](shared)
    settled(shared.page)
    assert complaints(shared.page) == []
    for _ in range(2):
        shared.page.keyboard.press("Escape")
    if STATES[name] in (running, job_that_runs):  # which has made up what the page knows
        shared.page.reload()
        shared.page.wait_for_selector("html[data-ready]", state="attached")
        shared.page.evaluate(axe)
        shared.page.evaluate(SET_UP)


@pytest.mark.parametrize("size", [(720, 450), (600, 900), (320, 700)])
def test_axe_finds_nothing_in_narrow_windows(shared: Desk, size: tuple[int, int]) -> None:
    page = shared.page
    shared.fresh()
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.get_by_role("button", name="Open the inspector").click()
    assert complaints(page) == []
    page.get_by_role("button", name="Close the inspector").click()
    page.get_by_role("button", name="More").click()
    page.locator("#top .menu").wait_for()
    assert complaints(page) == []
    page.keyboard.press("Escape")
    page.set_viewport_size({"width": SIZE[0], "height": SIZE[1]})


def test_axe_finds_nothing_in_the_guide_to_a_pose(shared: Desk) -> None:
    page = shared.page
    shared.fresh()
    page.keyboard.press("?")
    page.get_by_text("Show the first-pose guide").click()
    until(lambda: page.locator("#guide h3").count(), "the guide")
    for _ in range(6):
        assert complaints(page) == [], title(page)
        step = title(page)
        button(page, "Next").click()
        until(lambda step=step: title(page) != step, f"the step after {step}")  # type: ignore[misc]
    assert complaints(page) == []
    page.keyboard.press("Escape")


def test_axe_finds_nothing_in_the_guide_of_a_new_film(
    browser: Browser, tmp_path: Path, axe: str
) -> None:
    with new_film(browser, tmp_path) as page:
        page.evaluate(axe)
        steps = ("Which lens?", "How is the camera tilted?", "Choose the person")
        for wanted in (*steps, "Pose every frame"):
            page.get_by_role("heading", name=wanted).wait_for()
            assert complaints(page) == [], wanted
            if wanted == steps[0]:
                page.keyboard.press("Enter")
            elif wanted in steps:  # what nobody has said yet is gone on without
                after = page.locator("#guide .steps button").nth(steps.index(wanted) + 1)
                after.click()


def test_axe_finds_nothing_on_the_start_screen_and_in_the_chooser(
    browser: Browser, tmp_path: Path, axe: str
) -> None:
    with (
        Keypose("--workspace", str(tmp_path)) as keypose,
        admit(browser, drawn=False, size=SIZE) as context,
    ):
        page = context.new_page()
        page.goto(keypose.address)
        page.wait_for_selector("html[data-ready]", state="attached")
        page.locator("#empty h1").wait_for()
        page.evaluate(axe)
        assert complaints(page) == []
        page.locator("#empty button").first.click()
        page.locator("dialog[open]").wait_for()
        assert complaints(page) == []


# --- forced colours


def contrasts(page: Page, selectors: Iterable[str]) -> dict[str, float]:
    """Between the lightest and the darkest that is seen of each element, as WCAG counts it."""
    shot = np.frombuffer(page.screenshot(), np.uint8)
    srgb = np.asarray(cv2.imdecode(shot, cv2.IMREAD_COLOR))[..., ::-1] / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    found = {}
    for selector in selectors:
        box = page.locator(selector).first.bounding_box()
        assert box is not None, selector
        left, top = math.floor(box["x"]), math.floor(box["y"])
        right, bottom = math.ceil(box["x"] + box["width"]), math.ceil(box["y"] + box["height"])
        seen = luminance[top:bottom, left:right]
        found[selector] = float((seen.max() + 0.05) / (seen.min() + 0.05))
    return found


SEEN = {
    "part": ("slide-bar .th", "number-field", ".seg", ".cb i", ".drop", "#insp .btn"),
    "track": (".switch.field i", "[role=tab][aria-selected=true]"),
}
ALWAYS = (
    "#top .switch i", "#tools [aria-pressed=true]", "#mdisp .th", "#mdisp .rng",
    "#tsvg .keymark", "#tsvg .playhead", ".job .bar", ".job", ".toast", ".counts .count.check",
)  # fmt: skip


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_in_forced_colours_what_colour_gives_is_seen(
    browser: Browser, shared: Desk, scheme: Any
) -> None:
    shared.fresh()
    shared.visitor.do(do="select", part="left_forearm")
    looks = {"forced_colors": "active", "color_scheme": scheme}
    with admit(browser, drawn=False, size=SIZE, **looks) as context:
        page = opened(context, shared.keypose)
        page.evaluate(SET_UP)
        page.evaluate("(news) => window.steady.feed(news)", at_work(page))
        page.mouse.move(2, 2)
        for name, found in SEEN.items():
            page.get_by_role("tab", name=name.title(), exact=True).click()
            faded(page)
            screen(page, f"forced-{scheme}-{name}")
            seen = contrasts(page, (*found, *ALWAYS))
            assert {what: ratio for what, ratio in seen.items() if ratio < 3} == {}
        colours = page.evaluate(
            """() => [...document.querySelectorAll('[role=tab], #tools .ib, #insp .seg button')]
              .map((one) =>
                [one.ariaSelected ?? one.ariaPressed, getComputedStyle(one).backgroundColor])"""
        )
        chosen = {colour for state, colour in colours if state == "true"}
        assert chosen.isdisjoint(colour for state, colour in colours if state == "false")


def at_work(page: Page) -> dict[str, Any]:
    """A job that runs, a segment of each verdict, a message."""
    states = ("good", "check", "lost")
    job = {"state": "running", "title": "Tracking 0–24", "words": "pass 1 of 3", "percent": 40}
    segments = [
        s | {"state": states[i % 3], "words": "", "short": ""}
        for i, s in enumerate(section(page, "segments"))
    ]
    return {
        "sections": {"job": job | {"seconds_left": 9, "kind": "track"}, "segments": segments},
        "ui": {},
        "toasts": [{"kind": "good", "words": "Keyframe deleted.", "button": {"label": "Undo"}}],
        "theme": "dark",
    }


# --- motion


def test_with_reduced_motion_nothing_moves_by_itself(browser: Browser, shared: Desk) -> None:
    shared.fresh()
    with admit(browser, drawn=False, size=SIZE, reduced_motion="reduce") as context:
        page = opened(context, shared.keypose)
        page.evaluate(SET_UP)
        page.evaluate("(news) => window.steady.feed(news)", at_work(page))
        tracking = [s | {"state": "tracking"} for s in section(page, "segments")]
        news = {"sections": {"segments": tracking}, "ui": {}, "toasts": [], "theme": "dark"}
        page.evaluate("(news) => window.steady.feed(news)", news)
        page.get_by_role("tab", name="Track").click()
        page.locator(".switch.field").first.click(force=True)  # refused: it shakes
        moving = "() => document.getAnimations().filter(({ playState }) => playState === 'running')"
        assert page.evaluate(f"{moving}.length") == 0


# --- handles that lie over each other


def test_a_second_press_and_tab_lead_to_the_handle_behind_and_a_drag_takes_it(
    shared: Desk,
) -> None:
    shared.fresh()
    page, place = shared.page, put_together(shared)
    page.mouse.move(place[0] - 60, place[1])
    page.mouse.move(*place)
    until(lambda: "1 of 2" in named(page), "the first of two")
    screen(page, "overlap-1")
    first = named(page).split(" 1 of")[0]
    page.keyboard.press("Tab")
    until(lambda: "2 of 2" in named(page), "the second")
    second = named(page).split(" 2 of")[0]
    assert {first, second} == {"Left hand", "Right hand"}
    screen(page, "overlap-2")
    before = section(page, "pose.points")
    page.mouse.down()
    page.mouse.move(place[0] + 30, place[1] + 6, steps=4)
    page.mouse.up()
    shared.agreed("pose")
    pulled = second.lower().replace(" ", "_")
    other = first.lower().replace(" ", "_")
    after = section(page, "pose.points")
    assert np.linalg.norm(np.subtract(after[pulled], before[pulled])) > 0.01
    assert np.linalg.norm(np.subtract(after[other], before[other])) < 0.005


def test_tab_goes_on_from_the_last_handle_and_clicks_go_round(shared: Desk) -> None:
    shared.fresh()
    page, place = shared.page, put_together(shared)
    page.mouse.move(place[0] - 60, place[1])
    page.mouse.move(*place)
    chosen = []
    for _ in range(3):
        page.mouse.click(*place)
        page.wait_for_timeout(450)  # slower than a double click
        chosen.append(shared.agreed("view")["selected"])
    assert chosen[0] == chosen[2] != chosen[1]
    for _ in range(2):
        page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement !== document.body")


def named(page: Page) -> str:
    """What is said of the handle under the pointer."""
    return " ".join(" ".join(page.locator("#main .hud .flt.name").all_inner_texts()).split())


def put_together(at: Desk) -> tuple[float, float]:
    """Pull the right hand onto the left one; where both are seen."""
    at.visitor.do(do="go", frame=0)
    at.agreed("pose")
    there = spot(at.page, "left_hand")
    for _ in range(3):
        here = spot(at.page, "right_hand")
        at.page.mouse.move(*here)
        at.page.mouse.down()
        at.page.mouse.move(*there, steps=4)
        at.page.mouse.up()
        at.agreed("pose")
    at.page.keyboard.press("v")
    return between(at.page, "left_hand", "right_hand")


# --- the keyboard alone


def focus(page: Page, label: str, most: int = 120) -> None:
    """Press Tab until the control of this name has the focus; wait until it is drawn first."""
    name = "(at) => (at?.getAttribute('aria-label') ?? at?.innerText ?? '').trim()"
    there = f"""(label) => [...document.querySelectorAll('button, input, [tabindex], [aria-label]')]
      .some((one) => ({name})(one).startsWith(label))"""
    until(lambda: page.evaluate(there, label), f"a control called {label}")
    for _ in range(most):
        if page.evaluate(f"() => ({name})(document.activeElement)").startswith(label):
            return
        page.keyboard.press("Tab")
    raise AssertionError(f"Tab does not lead to {label}")


def test_a_first_pose_is_made_and_tracked_with_the_keyboard_alone(
    browser: Browser, tmp_path: Path
) -> None:
    with new_film(browser, tmp_path) as page:
        page.keyboard.press("1")  # a phone's lens
        until_state(page, "camera.lens_source", lambda source: source == "person")
        page.keyboard.press("Enter")
        until(lambda: title(page) == "How is the camera tilted?", "the camera")
        focus(page, "Level camera")
        page.keyboard.press("Enter")
        until(lambda: title(page) == "Choose the person", "the person")
        focus(page, "Pose by hand instead")
        page.keyboard.press("Enter")
        until(lambda: title(page) == "Drag the waist onto the hips", "posing by hand")
        focus(page, "Across")
        typed(page, "0.5", "pose.root", lambda root: abs(root[0] - 0.5) < 0.01)
        focus(page, "Depth")
        typed(page, "5", "pose.root", lambda root: abs(root[2] - 5) < 0.01)
        page.keyboard.press("Escape")
        page.keyboard.press("]")
        until_state(page, "view.selected", lambda part: part != "waist")
        focus(page, "Bend")
        bend = section(page, "pose.angles")
        page.keyboard.press("ArrowRight")
        until_state(page, "pose.angles", lambda angles: angles != bend)
        until_state(page, "pose.stroke", lambda stroke: stroke is None)  # else Esc would cancel it
        page.keyboard.press("Escape")
        page.keyboard.press("k")
        until_state(page, "keys.frames", lambda frames: frames == [0])
        for _ in range(2):
            page.keyboard.press("Shift+ArrowRight")
        until_state(page, "view.frame", lambda frame: frame == 20)
        page.keyboard.press("k")
        until_state(page, "keys.frames", lambda frames: frames == [0, 20])
        page.keyboard.press("t")
        until_state(page, "job.state", lambda state: state == "done")
        until_counted(page, "#tsvg .playhead", 1)
        page.keyboard.press("n")
        answered(page)
        assert section(page, "segments")[0]["state"] in ("good", "check", "lost")


def typed(page: Page, value: str, path: str, wanted: Callable[[Any], bool]) -> None:
    """Type into the focused field, and wait for what it sets."""
    page.keyboard.press("Control+a")
    page.keyboard.type(value)
    page.keyboard.press("Enter")
    until_state(page, path, wanted)


def test_what_gets_the_focus_after_a_click_keeps_it(shared: Desk) -> None:
    """The click gives the focus back with the next frame, which a slow page draws late."""
    clicked, later = (
        shared.page.evaluate(
            """(moves) => {
              const [one, other] = document.querySelectorAll('[role=tab]');
              one.dispatchEvent(new PointerEvent('pointerdown', {bubbles: true}));
              one.focus();
              one.click();
              if (moves) other.focus();
              const drawn = new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
              return drawn.then(() => document.activeElement === (moves ? other : one));
            }""",
            moves,
        )
        for moves in (False, True)
    )
    assert not clicked
    assert later
