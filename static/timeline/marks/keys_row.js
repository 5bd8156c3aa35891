// The row of keyframes between its marks, and the names left of all rows: there a box over keyframes begins.

import { svg } from '../../vendor/lit-html/lit-html.js';
import { goTo, stopPlaying } from '../../actions/playhead.js';
import { clearSelection, selectBetween, selectedKeys, selectKeys } from '../../actions/selection.js';
import { reveal } from '../../actions/window.js';
import { clampFrame } from '../../store/clip.js';
import { frameAt, GUTTER, isIn, x } from '../draw/scale.js';

/**
 * Pull a box over keyframes; with Shift or Ctrl they come beside those selected.
 * @returns {import('../mark.js').Gesture}
 */
export function grabBox(_, start) {
  const before = selectedKeys();
  const kept = start.shift || start.ctrl ? before : [];
  const from = frameAt(start.x);
  return {
    move(place) {
      const to = frameAt(place.x);
      reveal(clampFrame(to), 0);
      selectBetween(Math.min(from, to), Math.max(from, to), kept);
      return { kind: 'box', from, to };
    },
    cancel: () => selectKeys(before),
  };
}

/** A click on the row goes there and lets go of the selection. */
export function clickRow(_, place) {
  clearSelection();
  stopPlaying();
  goTo(frameAt(place.x));
}

/** A box over the first keyframe begins beside it. @type {import('../mark.js').Mark} */
export const edge = {
  kind: 'edge',
  hit: ({ x: px }) => px < GUTTER && {},
  grab: (what, place, { rows }) => (isIn(rows.keys, place.y) ? grabBox(what, place) : null),
};

/** @type {import('../mark.js').Mark} */
export const keysRow = {
  kind: 'box',
  row: 'keys',
  hit: () => ({}),
  grab: grabBox,
  click: clickRow,
  drag({ from, to }, { keys }) {
    const [left, right] = [Math.max(GUTTER + 1, Math.min(x(from), x(to))), Math.max(x(from), x(to))];
    return svg`<rect class="selbox" x=${left} y=${keys.y + 1.5} width=${Math.max(0, right - left)} height=${keys.h - 4}
      rx="2" />`;
  },
};
