// The menu of what lies in a view: of a part, of the picture where there is none. At the pointer on
// the right button; from the keyboard of the selected part, beside it.

import { menuItem } from '../actions/buttons.js';
import { contextEntries } from '../actions/context_menus.js';
import { allPins, framesOf, isEnd, pinHere, pinTitle } from '../actions/pins.js';
import { frame } from '../actions/playhead.js';
import { heading, line, openMenuAt } from '../controls/menu.js';
import { partNamed, selectedPart } from '../store/parts.js';
import { server, ui } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { pick } from './hover.js';
import { interaction } from './interaction.js';
import { largeView } from './scale.js';
import { partOf, select } from './select.js';
import { isDrawingTool } from './sketch.js';
import { isReady, targetAt } from './targets.js';

/** Entries about the eye; `part` is what was pressed on, if anything. */
export function freeEntries(view, part = null) {
  const look = (words, axis) => ({ label: words, icon: 'camc', run: () => view.alongAxis(axis) });
  return [
    ...orbitEntries(view, part?.name),
    line,
    look('Look from the side', 'x'),
    look('Look from above', 'y'),
    look('Look from the front', 'z'),
    line,
    ...contextEntries('eye'),
  ];
}

/** About what one orbits, and what the eye does by itself. */
export function orbitEntries(view, part) {
  const { about, follows, turns } = view.habits;
  return [
    {
      label: part ? `About ${partNamed(part).label.toLowerCase()}` : 'About the part',
      icon: 'rot',
      checked: about === 'part',
      run: () => view.choose('about', 'part'),
    },
    { label: 'About the body', icon: 'rot', checked: about === 'body', run: () => view.choose('about', 'body') },
    { label: 'Follow the body', icon: 'move', checked: follows, run: () => view.choose('follows', !follows) },
    { label: 'Turntable while playing', icon: 'play', checked: turns, run: () => view.choose('turns', !turns) },
  ];
}

/**
 * What a menu of a part says about pins; nothing for parts that are neither ends nor pinned, but for
 * the corners of boxes: `at` is where the menu opens, in pixels of the camera's view.
 */
export function pinEntries(part, at = null) {
  const here = pinHere(part);
  if (!part) return [];
  if (!isEnd(part) && here === undefined) {
    const corner = at && part.shape === 'box' ? menuItem('pinCorner', { part: part.name, at }) : null;
    return corner ? [heading(pinTitle(part)), corner] : [];
  }
  const pin = allPins()[here];
  if (!pin) return [heading(pinTitle(part)), menuItem('pin', part), menuItem('pinToFloor', part)];
  const now = server.view.frame;
  return [
    heading(pinTitle(part)),
    pin.floor ? null : menuItem('pinToFloor', part),
    now > pin.first ? menuItem('beginPin', part) : null,
    now < pin.last ? menuItem('endPin', part) : null,
    line,
    menuItem('unpin', here, { right: framesOf(pin) }),
  ];
}

const BESIDE_PX = 16;

/** How often something was pressed, by pointer or key. */
let acts = 0;

/** The right button on a view: the menu of what is there. */
export async function openAt(view, event) {
  if (!isReady(view) || isDrawingTool(ui.tool) || interaction.drag) return;
  const box = view.over.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const target = targetAt(view, x, y);
  const name = target && partOf(target);
  const picked = name ? Promise.resolve({ parts: [name] }) : pick(view, x, y);
  return openWhenPicked(view, picked, [event.clientX, event.clientY], [x, y]);
}

/**
 * The menu of the first of the parts at a place, unless one has gone on before they were known: it
 * would open over what one does now, and take the keys.
 * @param {any} view
 * @param {Promise<{ parts: string[] }>} picked
 * @param {[number, number]} place
 * @param {[number, number] | null} at
 */
export async function openWhenPicked(view, picked, place, at = null) {
  const asked = acts;
  const { parts } = await picked;
  if (asked === acts && isReady(view)) openViewMenu(view, parts[0], place, at);
}

/**
 * The menu of a part, by its name, or of the picture, at a place of the window.
 * @param {any} view
 * @param {string | undefined} name
 * @param {[number, number]} place
 * @param {[number, number] | null} at  In pixels of the view, where the pointer asked for it.
 */
function openViewMenu(view, name, place, at = null) {
  const part = name ? partNamed(name) : undefined;
  if (!part) return openMenuAt(`Frame ${frame()}`, pictureEntries(view), place);
  select(part.name);
  const corner = at && view.name === 'main' ? view.toView(at) : null;
  return openMenuAt(part.label, partEntries(view, part, corner), place);
}

function pictureEntries(view) {
  const title = heading(`Frame ${frame()}`);
  if (view.orbitBy) return [title, ...contextEntries('free'), line, ...freeEntries(view)];
  return [title, ...contextEntries('picture')];
}

function partEntries(view, part, corner) {
  const pins = pinEntries(part, corner);
  const title = pins.length ? [] : [heading(part.label)];
  const about = { keyLimb: part, turnInDepth: part, resetPart: part, otherSide: part };
  const more = view.orbitBy
    ? [...contextEntries('freePart', about), line, ...freeEntries(view, part)]
    : contextEntries('part', about);
  return [...title, ...pins, ...(pins.length ? [line] : []), ...more];
}

/** From the keyboard: the menu of the selected part, where it is seen; of the picture where none is. */
export function listenForMenuKey() {
  addEventListener('pointerdown', () => (acts += 1), true);
  addEventListener('keydown', ({ repeat }) => (acts += Number(!repeat)), true);
  addEventListener('contextmenu', (event) => {
    const isPointers = event.button === 2 || event.defaultPrevented;
    const isElsewhere = /** @type {Element} */ (event.target).closest?.('input, textarea, dialog, .menu');
    if (isPointers || isElsewhere || !server.file || !server.pose) return;
    event.preventDefault();
    openFromKeys(viewNamed(largeView()), selectedPart());
  });
}

function openFromKeys(view, part) {
  const box = view.over.getBoundingClientRect();
  const [x, y] = part ? view.project(server.pose.points[part.name]) : [box.width / 2, box.height / 3];
  openViewMenu(view, part?.name, [box.left + x + BESIDE_PX, box.top + y]);
}
