// Shapes that several marks are drawn with.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { clamp } from '../../controls/arithmetic.js';
import { GUTTER, right } from './scale.js';

/** A diamond about a point, as path data. */
export function diamond(cx, cy, r) {
  return `M${cx} ${cy - r}l${r} ${r}-${r} ${r}-${r}-${r}z`;
}

export const LETTER_PX = 6.6;

/** Words on a small plate, kept within the drawing; `more` follows them quietly. */
export function plate(words, at, y, more = '') {
  const wide = (words.length + more.length) * LETTER_PX + 14;
  const centre = clamp(at, GUTTER + 4 + wide / 2, right() + 22 - wide / 2);
  return svg`<g class="plate"><rect x=${centre - wide / 2} y=${y - 10} width=${wide} height="20" rx="4" />
    <text x=${centre} y=${y + 4}
      text-anchor="middle">${words}${more ? svg`<tspan class="more">${more}</tspan>` : nothing}</text></g>`;
}

/** What a mark of the keyframes' row is called, below it. */
export const named = (words, at, rows, more) => plate(words, at, rows.keys.middle + 23, more);
