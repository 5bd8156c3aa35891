// The grab handles: hands, feet, head, the joints between, shoulders and hips, and the diamond that
// carries the body.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';
import { partNamed } from '../store/parts.js';
import { server, ui } from '../store/state.js';
import { sightSeen } from '../views/sight.js';
import { interaction, isDragged, isHot } from './interaction.js';
import { isOfPlace } from './marks.js';
import { gripScale, isLarge } from './scale.js';
import { add, pathOf, unit } from './space.js';

const RADIUS = { end: 6, head: 6, middle: 4, corner: 4, root: 8 };
const SENT_AS = { end: 'end', head: 'end', middle: 'joint', corner: 'joint' };
const DEPTH_GUIDE = 44;

/** The grab handles in a view: [{key, handle, at, radius, label, part, …}]. */
export function gripsIn(view) {
  if (ui.tool === 'size') return [];
  return server.body.handles.map((given) => gripOf(view, given)).filter(Boolean);
}

function gripOf(view, given) {
  const point = server.pose.points[given.anchor];
  if (!point) return null;
  const [x, y] = view.project(point);
  if (!Number.isFinite(x + y)) return null;
  const { kind, name, part, label, limb } = given;
  const handle = kind === 'root' ? { kind } : { kind: SENT_AS[kind], name };
  const radius = RADIUS[kind] * gripScale(view);
  return { key: `grip:${name}`, kind, handle, part, label, limb, point, at: [x, y], radius };
}

export function drawGrips(view, grips) {
  return svg`<g class="grips">${hotLast(view, grips).map((grip) => drawGrip(view, grip))}</g>`;
}

/** Where handles lie over each other the one that is meant is seen. */
const hotLast = (view, grips) => [...grips].sort((a, b) => Number(isHot(view, a)) - Number(isHot(view, b)));

function drawGrip(view, grip) {
  const dragged = isDragged(grip);
  const { gesture } = server.pose;
  const far = (dragged && gesture?.out_of_reach) || gesture?.unreached.includes(grip.handle.name);
  const state = [
    dragged ? 'dragged' : '',
    far ? 'far' : '',
    isHot(view, grip) ? 'hot' : '',
    isOfPlace(grip) ? '' : 'aside',
  ].join(' ');
  const classes = `grip ${grip.kind} ${state}`;
  const grown = dragged ? 1.5 : isHot(view, grip) ? 1.33 : 1;
  const r = grip.radius * grown;
  const [x, y] = grip.at;
  if (grip.kind === 'root') {
    const d = `M${x} ${y - r}l${r} ${r}-${r} ${r}-${r}-${r}z`;
    return svg`<path class=${classes} d=${d} data-grip=${grip.key} />`;
  }
  return svg`<circle class=${classes} cx=${x} cy=${y} r=${r} data-grip=${grip.key} />`;
}

/** While an end is dragged: how far it can go, where it came from, and which way depth lies. */
export function drawReach(view, grips) {
  const gesture = server.pose.gesture;
  const grip = grips.find(isDragged);
  return svg`${gesture?.reach ? drawCircle(view, gesture.reach) : nothing}
    ${grip ? drawOrigin(view, grip) : nothing}
    ${grip && !isFilms(view) ? drawDepth(view, grip) : nothing}
    ${isFilms(view) && interaction.drag?.view !== view.name ? drawSight(view) : nothing}`;
}

const isFilms = ({ name }) => name === 'main' || name === 'film';

/** In the picture of a film: where a joint may lie that is being dragged in another one's. */
function drawSight(view) {
  const line = sightSeen((p) => view.project(p));
  return line.length ? svg`<path class="depth" d=${pathOf(line)} />` : nothing;
}

function drawCircle(view, { centre, radius_m }) {
  const [x, y] = view.project(centre);
  const r = radius_m * view.pxPerMetre(centre);
  if (!(r > 0)) return nothing;
  return svg`<circle class="reach" cx=${x} cy=${y} r=${r} />`;
}

function drawOrigin(view, grip) {
  const begun = interaction.drag.point;
  if (!begun || !isLarge(view)) return nothing;
  const [x, y] = view.project(begun);
  return svg`<path class="pulled" d=${pathOf([[x, y], grip.at])} />
    <circle class="origin" cx=${x} cy=${y} r="4" />`;
}

/** A line through the handle along the line of sight to it: the way nearer and farther. */
function drawDepth(view, grip) {
  const [x, y] = grip.at;
  const sight = add(grip.point, ui.sight?.place ?? [0, 0, 0], -1);
  const far = view.project(add(grip.point, unit(sight), 0.1));
  const [dx, dy] = [far[0] - x, far[1] - y];
  const length = Math.hypot(dx, dy);
  // Seen along the ray there is no way to show.
  if (length < 0.02 * view.pxPerMetre(grip.point)) return nothing;
  const [ux, uy] = [(dx / length) * DEPTH_GUIDE, (dy / length) * DEPTH_GUIDE];
  return svg`<path class="depth" d="M${x - ux} ${y - uy}L${x + ux} ${y + uy}" />`;
}

/** The limb that was chosen by a double click, as a line along its joints. */
export function drawLimb(view) {
  const limb = ui.limb ?? [];
  if (limb.length < 2) return nothing;
  const joints = limb.map((part) => server.pose.points[part]).filter(Boolean);
  const last = partNamed(limb.at(-1));
  const tip = last?.landmarks.map((name) => server.pose.points[name]).find(Boolean);
  const points = [...joints, ...(tip ? [tip] : [])].map((p) => view.project(p));
  return svg`<path class="limb" d=${pathOf(points)} />`;
}
