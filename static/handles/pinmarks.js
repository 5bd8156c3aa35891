// Pins on the views: a disc with an anchor at every point that is held at this frame, and the print of
// every foot that was put down.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';
import { allPins, isPinAt } from '../actions/pins.js';
import { ANCHOR } from '../controls/icons.js';
import { server } from '../store/state.js';
import { isLarge } from './scale.js';
import { pathOf } from './space.js';

const RADIUS = { large: 9, small: 7 };
const ANCHOR_SHARE = 1.3; // of the radius: how wide the anchor is drawn

/** The print of the soles, below the body's handles. */
export function drawSoles(view) {
  const pins = allPins().filter(({ sole }) => sole.length > 2);
  return pins.length ? svg`<g class="soles">${pins.map((pin) => drawSole(view, pin))}</g>` : nothing;
}

function drawSole(view, pin) {
  const corners = pin.sole.map((p) => view.project(p));
  if (!corners.every(isSeen)) return nothing;
  const now = isPinAt(pin, server.view.frame) ? '' : 'elsewhere';
  return svg`<path class=${`sole ${colour(pin)} ${now}`} d=${pathOf(corners, true)} />`;
}

/** A mark at every held point. */
export function drawPinMarks(view) {
  const held = allPins().filter((pin) => isPinAt(pin, server.view.frame));
  const r = isLarge(view) ? RADIUS.large : RADIUS.small;
  return svg`<g class="pinmarks">${held.flatMap((pin) => pointsOf(pin).map((p) => drawMark(view, pin, p, r)))}</g>`;
}

function drawMark(view, pin, point, r) {
  const at = view.project(point);
  if (!isSeen(at)) return nothing;
  const size = 2 * r * ANCHOR_SHARE / 2;
  return svg`<g class=${`pinmark ${colour(pin)}`} transform=${`translate(${at[0].toFixed(1)} ${at[1].toFixed(1)})`}>
    <circle r=${r} /><svg x=${-size / 2} y=${-size / 2} width=${size} height=${size} viewBox="0 0 16 16">${ANCHOR}</svg></g>`;
}

const colour = (pin) => (pin.problem ? 'wrong' : pin.side);

/** The points a pin holds, where they are now. */
function pointsOf(pin) {
  const { points, T } = server.pose;
  if (pin.point_m) return T[pin.part] ? [placed(pin.point_m, T[pin.part])] : [];
  const names = pin.landmarks.length ? pin.landmarks : [pin.part];
  return names.map((name) => points[name]).filter(Boolean);
}

const placed = ([x, y, z], T) => [0, 4, 8].map((i) => T[i] * x + T[i + 1] * y + T[i + 2] * z + T[i + 3]);

const isSeen = ([x, y]) => Number.isFinite(x + y);
