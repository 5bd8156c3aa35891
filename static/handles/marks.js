// Marks on the views: pins, the place that is reviewed, frame numbers on the motion trail. The line
// itself belongs to the scene.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { allPins, isPinAt } from '../actions/pins.js';
import { place } from '../actions/review.js';
import { ANCHOR } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server } from '../store/state.js';
import { movedBack } from '../views/world.js';
import { isHot } from './interaction.js';
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
  const corners = pin.sole.map((p) => view.project(movedBack(p, server.camera_here)));
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
  const size = (2 * r * ANCHOR_SHARE) / 2;
  return svg`<g class=${`pinmark ${colour(pin)}`} transform=${`translate(${at[0].toFixed(1)} ${at[1].toFixed(1)})`}>
    <circle r=${r} /><svg x=${-size / 2} y=${-size / 2} width=${size} height=${size}
      viewBox="0 0 16 16">${ANCHOR}</svg></g>`;
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

const LEAST_PX = 9;

/** The place, on its own frame. */
function placeHere() {
  const row = place();
  return row && row.frame === server.view?.frame ? row : undefined;
}

/** Whether a handle is of the limb that is looked at; the others step back. */
export const isOfPlace = ({ limb, part }) => {
  const name = placeHere()?.part;
  return !name || (limb ?? [part]).includes(name);
};

export function drawPlace(view) {
  const row = placeHere();
  if (!row || row.px === null) return nothing;
  const [x, y] = view.project(row.end);
  if (!Number.isFinite(x + y)) return nothing;
  const r = Math.max(LEAST_PX, row.radius_m * view.pxPerMetre(row.end));
  return svg`<circle class="doubt" cx=${x} cy=${y} r=${r} />`;
}

/** "Right wrist ≈ 9 px · 4 cm" above the circle in the large view. */
export function drawPlaceName(view) {
  const row = placeHere();
  if (!row || view.name !== 'main' || row.px === null) return nothing;
  const [x, y] = view.project(row.end);
  if (!Number.isFinite(x + y)) return nothing;
  const r = Math.max(LEAST_PX, row.radius_m * view.pxPerMetre(row.end));
  return html`<div class="flt doubted num" style="left:${x + r + 10}px;top:${y - r - 12}px">
    <b>${row.label}</b> <span class="warned">${row.size}</span></div>`;
}

/** The trail's keyframes in a view, the present one left out. */
export function trailKeysIn(view) {
  if (view.trailKeys) return view.trailKeys().map(keyOfWay);
  const trail = server.trail;
  if (!trail) return [];
  const keys = new Set(trail.keys);
  return trail.points
    .filter(([frame]) => keys.has(frame) && frame !== server.view.frame)
    .map(([frame, ...point]) => {
      const [x, y] = view.project(point);
      return wayTo(frame, { key: `trail:${frame}`, at: [x, y], label: `Frame ${frame}` });
    });
}

/** A click goes to the frame. */
const wayTo = (frame, key) => ({
  ...key,
  kind: 'trail',
  frame,
  cursor: 'pointer',
  click: () => send({ do: 'go', frame }),
});

/** In the free view they lie on the ways of the feet. */
const keyOfWay = ({ part, frame, at, label }) =>
  wayTo(frame, { key: `trail:${part}:${frame}`, at: at.slice(0, 2), label });

export function drawTrail(view, keys) {
  if (view.trailKeys) return svg`<g class="trail">${keys.map((target) => drawWayKey(view, target))}</g>`;
  if (!server.trail || !(server.view.trail || server.view.ghosts)) return nothing;
  return svg`<g class="trail">
    ${isLarge(view) ? drawFrames(view) : nothing}
    ${keys.map((target) => drawKey(view, target))}
  </g>`;
}

/** A dot for every second frame: close together where the motion is slow. */
function drawFrames(view) {
  if (!server.view.trail) return nothing;
  return server.trail.points
    .filter(([frame]) => frame % 2 && frame !== server.view.frame)
    .map(([, ...point]) => {
      const [x, y] = view.project(point);
      return svg`<circle class="dot" cx=${x} cy=${y} r="1.5" />`;
    });
}

function drawWayKey(view, target) {
  const r = isHot(view, target) ? 6 : 4;
  const [x, y] = target.at;
  const state = target.frame === server.view.frame ? 'present' : '';
  return svg`<path class="key ${state}" d="M${x} ${y - r}l${r} ${r}-${r} ${r}-${r}-${r}z" />`;
}

function drawKey(view, target) {
  const large = isLarge(view);
  const r = (large ? 5 : 3.5) * (isHot(view, target) ? 1.3 : 1);
  const [x, y] = target.at;
  const before = target.frame < server.view.frame;
  const left = leftOf(view, target, before);
  return svg`<path class="key" d="M${x} ${y - r}l${r} ${r}-${r} ${r}-${r}-${r}z" />
    ${
      large
        ? svg`<text class=${left ? 'left' : ''} x=${x + (left ? -9 : 9)} y=${y + 4}>${target.frame}</text>`
        : nothing
    }`;
}

/** The number stands on the side away from where the motion goes on. */
function leftOf(view, target, before) {
  const points = server.trail.points;
  const at = points.findIndex(([frame]) => frame === target.frame);
  const next = points[at + (before ? 1 : -1)];
  if (!next) return !before;
  return view.project(next.slice(1))[0] > target.at[0];
}
