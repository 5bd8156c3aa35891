// What can be pinned of a part, as a menu: at the pointer on the right button, beside the selected part
// from the keyboard.

import { heading, line, openMenuAt } from '../controls/menu.js';
import { menuItem } from '../actions/buttons.js';
import { allPins, framesOf, isEnd, pinHere, pinTitle } from '../actions/pins.js';
import { server, ui } from '../store/state.js';
import { partNamed, selectedPart } from '../store/parts.js';
import { view as viewNamed } from '../views/views.js';
import { pick } from './hover.js';
import { interaction } from './interaction.js';
import { largeView } from './scale.js';
import { select } from './select.js';
import { isDrawingTool } from './sketch.js';
import { isReady, targetAt } from './targets.js';

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
    line, menuItem('unpin', here, { right: framesOf(pin) }),
  ];
}

/** The right button on a view: the menu of the part that is there. */
export async function openAt(view, event) {
  if (!isReady(view) || isDrawingTool(ui.tool) || interaction.drag) return;
  const box = view.over.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const target = targetAt(view, x, y);
  const name = target?.part ?? (await pick(view, x, y)).parts[0];
  if (!name) return;
  select(name);
  openFor(partNamed(name), [event.clientX, event.clientY], view.name === 'main' ? view.toView([x, y]) : null);
}

/** From the keyboard: the menu of the selected part, where it is seen. */
export function listenForMenuKey() {
  addEventListener('contextmenu', (event) => {
    const isPointers = event.button === 2 || event.defaultPrevented;
    const part = selectedPart();
    if (isPointers || !part || !server.pose || /** @type {Element} */ (event.target).closest?.('input, textarea')) return;
    event.preventDefault();
    const view = viewNamed(largeView());
    const box = view.over.getBoundingClientRect();
    const [x, y] = view.project(server.pose.points[part.name]);
    openFor(part, [box.left + x + 16, box.top + y]);
  });
}

function openFor(part, place, at = null) {
  const pins = pinEntries(part, at);
  const title = pins.length ? [] : [heading(part.label)];
  openMenuAt(part.label, [...title, ...pins, ...(pins.length ? [line] : []), menuItem('keyLimb'), menuItem('turnInDepth', part)], place);
}
