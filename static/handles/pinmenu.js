// What can be pinned of a part, as entries of its menu.

import { heading, line } from '../controls/menu.js';
import { menuItem } from '../actions/buttons.js';
import { allPins, framesOf, isEnd, pinHere, pinTitle } from '../actions/pins.js';
import { server } from '../store/state.js';

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
