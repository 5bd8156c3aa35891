// What is held or hovered: the key on its way, the angle being changed, the mark under the pointer.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { GUTTER, right, x } from './scale.js';
import { barOf, BAR } from './segments.js';
import { diamond } from './patterns.js';
import { held, hovered } from '../edit/held.js';
import { partOf, scale, valueAt } from './curve.js';

const LETTER_PX = 6.6;

export function drawHeld(rows) {
  const what = held();
  if (what?.kind === 'key') return drawMovingKey(what, rows);
  if (what?.kind === 'angle') return drawAngle(what, rows);
  return what === null ? drawHover(rows) : nothing;
}

function drawMovingKey({ from, to, copy, taken, refused }, rows) {
  const middle = rows.keys.middle;
  const words = taken ? `${to} is a keyframe` : `${from} ${copy ? '+' : '→'} ${to}`;
  const home = copy ? nothing : svg`<path class="home" d=${diamond(x(from), middle, 5)} />`;
  return svg`${home}<g class=${refused ? 'shake' : ''}>
      <path class=${`moving${taken ? ' taken' : ''}`} d=${diamond(x(to), middle, 8)} /></g>
    ${label(words, x(to), middle + 22)}`;
}

function drawAngle({ frame, part, axis, from, deg }, rows) {
  const at = rows.curve === null ? null : scale(rows.curve);
  if (at === null) return nothing;
  const y = Math.min(rows.curve.y + rows.curve.h, Math.max(rows.curve.y, at.y(deg)));
  const word = partOf(part)?.words?.[axis] ?? axis.toUpperCase();
  const words = `${word} ${figure(deg)}°  ${signed(deg - from)}`;
  return svg`<path class="curvekey current" d=${diamond(x(frame), y, 6)} />
    ${beside(words, x(frame), y, rows)}`;
}

const figure = (value) => value.toFixed(1).replace('-', '−');
const signed = (value) => (value < 0 ? figure(value) : `+${figure(value)}`);

/** Words beside a point of the curve, on the side where there is room. */
function beside(words, at, y, rows) {
  const half = (words.length * LETTER_PX) / 2 + 7;
  const side = at + 2 * half + 24 > right() ? -1 : 1;
  const low = rows.curve.y + rows.curve.h - 10;
  return label(words, at + side * (half + 12), Math.min(low, Math.max(rows.curve.y + 8, y)));
}

/** Words on a small plate, kept within the drawing. */
function label(words, at, y) {
  const wide = words.length * LETTER_PX + 14;
  const centre = Math.min(right() + 22 - wide / 2, Math.max(GUTTER + 4 + wide / 2, at));
  return svg`<g class="plate"><rect x=${centre - wide / 2} y=${y - 10} width=${wide} height="20" rx="4" />
    <text x=${centre} y=${y + 4} text-anchor="middle">${words}</text></g>`;
}

function drawHover(rows) {
  const what = hovered();
  if (what === null) return nothing;
  const middle = rows.keys.middle;
  if (what.kind === 'key') {
    return svg`<path class="hover" d=${diamond(x(what.frame), middle, 9.5)} />
      ${label(`Keyframe ${what.frame}`, x(what.frame), middle + 23)}`;
  }
  if (what.kind === 'curvekey') return drawCurveHover(what.frame, rows);
  const segment = (server.segments ?? []).find(({ first }) => first === what.first);
  if (!segment) return nothing;
  const { from, to } = barOf(segment);
  return svg`<rect class="hover" x=${from - 1.5} y=${middle - BAR.half - 1.5} rx="4"
    width=${Math.max(1, to - from) + 3} height=${2 * BAR.half + 3} />`;
}

function drawCurveHover(frame, rows) {
  const at = rows.curve === null ? null : scale(rows.curve);
  const value = valueAt(frame);
  if (at === null || value === null) return nothing;
  const y = at.y(value);
  return svg`<path class="hover" d=${diamond(x(frame), y, 7)} />
    ${beside(`${figure(value)}°`, x(frame), y, rows)}`;
}
