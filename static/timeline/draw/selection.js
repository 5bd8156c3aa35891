// The selected keyframes: a band behind them with a grip at either end, which stretches them; the box
// that selects; and the keyframes on their way to other frames.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { clamp } from '../../controls/arithmetic.js';
import { count, range } from '../../controls/words.js';
import { selectedKeys } from '../../actions/selection.js';
import { diamond } from './keymarks.js';
import { GUTTER, x } from './scale.js';

const AIR = 10;
const REACH = 6;
const GRIP = { wide: 4, high: 16 };

/** Left and right edge of the band; null where fewer than two keyframes are selected. At the first
 * frame it keeps clear of the names of the rows. */
function edges(frames) {
  if (frames.length < 2) return null;
  const first = x(frames[0]);
  return { first: first < GUTTER ? first - AIR : Math.max(first - AIR, GUTTER + 2), last: x(frames.at(-1)) + AIR };
}

/** The band lies under the segments: their colours stay as they are. */
export function drawSelectionBand(rows, frames) {
  const at = edges(frames);
  if (at === null) return nothing;
  return svg`<rect class="selband" x=${at.first} y=${rows.keys.y + 1.5} width=${at.last - at.first} height=${rows.keys.h - 4} rx="4" />`;
}

export function drawGrips(rows, frames) {
  const at = edges(frames);
  if (at === null) return nothing;
  const { y, h } = rows.keys;
  const grip = (px) => svg`<rect class="selgrip" x=${px - GRIP.wide / 2} y=${y + (h - GRIP.high) / 2} width=${GRIP.wide} height=${GRIP.high} rx="2" />`;
  return svg`${grip(at.first)}${grip(at.last)}`;
}

/** "first" or "last": the grip at a pixel of the keyframes' row; null beside both. */
export function gripNear(px) {
  const frames = selectedKeys();
  const at = edges(frames);
  if (at === null) return null;
  const isNearer = (end, frame) => x(frame) > GUTTER && Math.abs(px - at[end]) <= REACH && Math.abs(px - at[end]) < Math.abs(px - x(frame));
  if (isNearer('first', frames[0])) return 'first';
  return isNearer('last', frames.at(-1)) ? 'last' : null;
}

export function drawBox({ from, to }, rows) {
  const [left, right] = [Math.max(GUTTER + 1, Math.min(x(from), x(to))), Math.max(x(from), x(to))];
  return svg`<rect class="selbox" x=${left} y=${rows.keys.y + 1.5} width=${Math.max(0, right - left)} height=${rows.keys.h - 4} rx="2" />`;
}

/** Where they would go; homes stay visible unless copies are made. `plate(words, x, y)` draws words. */
export function drawMovingKeys(what, rows, plate) {
  const { frames, to, copy, taken, refused, held } = what;
  const middle = rows.keys.middle;
  const homes = copy ? nothing : svg`<path class="home" d=${frames.map((at) => diamond(x(at), middle, 4.5)).join('')} />`;
  const there = to[frames.indexOf(held)];
  return svg`${drawSelectionBand(rows, to)}${drawGrips(rows, to)}${homes}
    <path class=${`moving chosen${taken ? ' taken' : ''}${refused ? ' shake' : ''}`} d=${to.map((at) => diamond(x(at), middle, 7)).join('')} />
    ${plate(taken || wordsOf(what), clamp(x(there), GUTTER, Infinity), middle + 22)}`;
}

function wordsOf({ frames, to, end, copy, held }) {
  if (end === null) {
    const by = to[0] - frames[0];
    return `${count(frames.length, 'keyframe')} ${by < 0 ? '−' : '+'}${Math.abs(by)}${copy ? ', copied' : ` · ${held} → ${held + by}`}`;
  }
  const percent = Math.round((100 * (to.at(-1) - to[0])) / (frames.at(-1) - frames[0]));
  return `${range(frames[0], frames.at(-1))} → ${range(to[0], to.at(-1))} · ${percent} %`;
}
