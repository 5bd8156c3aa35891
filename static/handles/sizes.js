// The handles of the Sizes tool on the selected part: a cap where its length ends, rims where it
// is thick, a cross on its joint.

import { svg } from '../vendor/lit-html/lit-html.js';
import { selectedPart } from '../store/parts.js';
import { server, ui } from '../store/state.js';
import { isDragged, isHot } from './interaction.js';
import { gripScale } from './scale.js';
import { add, distance, axesOf, originOf, pathOf, times } from './space.js';

/** A width or a depth seen almost end on cannot be pulled; another view shows it better. */
const FLATTEST_PX = 6;

/** The size handles in a view. */
export function sizesIn(view) {
  const part = ui.tool === 'size' && selectedPart();
  const T = part && server.pose.T[part.name];
  if (!T) return [];
  const sizes = part.sizes.map((given) => sizeOf(view, part, given)).filter(Boolean);
  return part.parent ? [...sizes, crossOf(view, part)] : sizes;
}

function sizeOf(view, part, given) {
  const handle = { kind: 'size', part: part.name, key: given.key };
  const common = { key: `size:${part.name}:${given.key}`, handle, part: part.name, label: given.label };
  const [x, y, z] = given.at_cm;
  const surface = screenOf(view, part, [x, y, z]);
  if (given.key === 'length') return { ...common, kind: 'cap', at: surface, across: across(view, part) };
  const foot = screenOf(view, part, [0, y, 0]);
  const at = given.key.endsWith('radius') ? beside(view, part, given, foot) : surface;
  return distance(at, foot) < FLATTEST_PX ? null : { ...common, kind: 'rim', at, foot };
}

/** A point of the part's frame, centimetres, on the screen. */
function screenOf(view, part, cm) {
  return view.project(pointOf(part, cm)).slice(0, 2);
}

function pointOf(part, cm) {
  const T = server.pose.T[part.name];
  const axes = axesOf(T);
  return axes.reduce((sum, axis, k) => add(sum, times(axis, cm[k] / 100)), originOf(T));
}

/** A radius reaches out at right angles to the part, whatever side one sees. Its size is how far the
 * part is across, so that the rim lies on the surface and follows the pointer. */
function beside(view, part, given, foot) {
  const reach = (given.cm / 200) * view.pxPerMetre(pointOf(part, given.at_cm));
  const [ux, uy] = across(view, part);
  return [foot[0] + ux * reach, foot[1] + uy * reach];
}

/** The direction on the screen at right angles to the part. */
function across(view, part) {
  const [near, far] = [screenOf(view, part, [0, 0, 0]), screenOf(view, part, [0, 10, 0])];
  const length = distance(near, far);
  return length < 1 ? [1, 0] : [(near[1] - far[1]) / length, (far[0] - near[0]) / length];
}

function crossOf(view, part) {
  const handle = { kind: 'size', part: part.name, key: 'joint', side: 'joint' };
  const at = screenOf(view, part, [0, 0, 0]);
  return { key: `size:${part.name}:joint`, kind: 'cross', handle, part: part.name, label: 'Joint', at };
}

export function drawSizes(view, sizes) {
  const k = gripScale(view);
  return svg`<g class="sizes">${sizes.map((target) => drawSize(view, target, k))}</g>`;
}

function drawSize(view, target, k) {
  const classes = `sizer ${target.kind} ${isDragged(target) ? 'dragged' : ''} ${isHot(view, target) ? 'hot' : ''}`;
  const [x, y] = target.at;
  if (target.kind === 'cap') {
    const [ux, uy] = target.across.map((v) => v * 11 * k);
    return svg`<path class=${classes} d="M${x - ux} ${y - uy}L${x + ux} ${y + uy}" data-grip=${target.key} />`;
  }
  if (target.kind === 'cross') {
    const r = 6 * k;
    const d = `M${x - r} ${y - r}l${2 * r} ${2 * r}m0 -${2 * r}l-${2 * r} ${2 * r}`;
    return svg`<path class=${classes} d=${d} data-grip=${target.key} />`;
  }
  return svg`<path class="spoke" d=${pathOf([target.foot, target.at])} />
    <circle class=${classes} cx=${x} cy=${y} r=${4.5 * k} data-grip=${target.key} />`;
}
