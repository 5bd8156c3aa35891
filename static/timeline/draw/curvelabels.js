// Left of the curve: whose it is, about which axis, and the numbers of its scale.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { onEnter } from '../../controls/focus.js';
import { server } from '../../store/state.js';
import { shortNumber } from '../../controls/arithmetic.js';
import { partNamed } from '../../store/parts.js';
import { GUTTER } from './scale.js';
import { axis, chooseAxis, hasCurve, hasError, scale } from './curve.js';

const AXES = ['x', 'y', 'z'];
const PITCH = 14;

const LETTER_PX = 6.2;

export function drawCurveLabels(row) {
  if (row === null || !hasCurve()) return nothing;
  const part = partNamed(server.curve.part);
  const name = part?.label ?? server.curve.part;
  const at = scale(row);
  const top = row.y + (row.h > 34 ? 14 : 12);
  const ticks = (at?.ticks ?? []).filter((value) => hasRoom(value, at.y(value), row, name));
  return svg`<text class="lbl" x="12" y=${top}>${name}</text>
    ${row.h > 34 ? drawAxes(part, top + 15) : nothing}
    ${row.h > 46 && hasError() ? drawErrorLabel(row) : nothing}
    ${ticks.map((value) => svg`<text class="d" x=${GUTTER - 8} y=${at.y(value) + 4}
      text-anchor="end">${shortNumber(value, 0)}</text>`)}`;
}

/** A number stands beside the name of the part only where the name is short enough. */
function hasRoom(value, y, row, name) {
  const nameEnds = 12 + LETTER_PX * name.length;
  return y > row.y + 22 || nameEnds < GUTTER - 12 - LETTER_PX * String(value).length;
}

function drawErrorLabel(row) {
  const y = row.y + 44;
  return svg`<text class="d" x="12" y=${y}>Error</text><path class="error" d=${`M44 ${y - 4}h16`} />`;
}

/** "X Y Z Bend": the letters choose the axis, the word says what turning about it does. */
function drawAxes(part, y) {
  const word = part?.words?.[axis()] ?? '';
  return svg`<g role="radiogroup" aria-label="Axis of the curve">
      ${AXES.map((name, i) => drawLetter(name, 12 + i * PITCH, y, part))}</g>
    <text x=${12 + 3 * PITCH + 2} y=${y}>${word}</text>`;
}

function drawLetter(name, x, y, part) {
  const word = part?.words?.[name] ?? '';
  const chosen = axis() === name;
  return svg`<g class=${`axis ${name}${chosen ? ' chosen' : ''}`} role="radio" tabindex="0"
      aria-checked=${String(chosen)} aria-label=${`${name.toUpperCase()} ${word}`}
      @click=${() => chooseAxis(name)} @keydown=${onEnter(() => chooseAxis(name))}>
    <title>${name.toUpperCase()} ${word}, degrees</title>
    <rect x=${x - 4} y=${y - 13} width=${PITCH + 1} height="18" rx="3" />
    <text x=${x} y=${y}>${name.toUpperCase()}</text></g>`;
}
