// The in and the out point under the pointer: an end is dragged, its menu clears it.

import { setUi, ui } from '../../store/state.js';
import { menuItem } from '../../actions/buttons.js';
import { openMenuAt } from '../../controls/menu.js';
import { clearEnd, keepSpan, withEndDragged } from '../../actions/playing.js';
import { keyFrames } from '../../actions/playhead.js';
import { nearest } from '../draw/keymarks.js';
import { frameAt, x } from '../draw/scale.js';
import { setGrabbed } from './pointer.js';

const SNAP_PX = 4;

/** Grab the in point ("first") or the out point ("last"). It snaps to keyframes; Alt: it does not. */
export function grabSpanEnd(end, start) {
  const before = ui.span;
  const offset = x(before[end]) - start.x;
  return {
    move(place) {
      const at = place.x + offset;
      const snapped = place.alt ? null : nearest(keyFrames(), at, SNAP_PX);
      setUi('span', withEndDragged(before, end, snapped ?? frameAt(at)));
      setGrabbed({ kind: 'span', end });
    },
    click: () => {},
    end() {
      setGrabbed(null);
      keepSpan(ui.span);
    },
    cancel() {
      setGrabbed(null);
      setUi('span', before);
    },
  };
}

export function openSpanMenu(end, page) {
  const word = end === 'first' ? 'In' : 'Out';
  openMenuAt(`${word} point ${ui.span[end]}`, [
    menuItem('goTo', ui.span[end]),
    { icon: 'x', label: `Clear the ${word.toLowerCase()} point`, run: () => clearEnd(end) },
    menuItem('clearSpan'),
    menuItem('loop'),
  ], page);
}
