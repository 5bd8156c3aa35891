// Ignore masks on the picture: hatched polygons; the chosen one can be pulled at its corners, a
// new corner is pulled out of the middle of an edge.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { beginDrag } from './drag.js';
import { isDragged, isHot } from './interaction.js';
import { inside, pathOf } from './space.js';

const HATCH_PX = 10;

/** The masks that cover the present frame, with their place in the list. */
function masksHere() {
  const frame = server.view.frame;
  return (server.masks ?? [])
    .map((mask, index) => ({ ...mask, index }))
    .filter(({ first, last }) => first <= frame && frame <= last);
}

/** What can be grabbed of the masks: borders, and the corners of the chosen one. */
export function masksIn(view) {
  if (view.name !== 'main' || ui.tool === 'mask') return [];
  return masksHere().flatMap((mask) => {
    const corners = mask.polygon.map((p) => view.fromView(p));
    const whole = wholeOf(mask, corners);
    return mask.index === ui.mask ? [...cornersOf(mask, corners), whole] : [whole];
  });
}

/** The border, by which the whole mask is moved. */
function wholeOf(mask, corners) {
  const { index, polygon } = mask;
  return {
    key: `mask:${index}`,
    kind: 'mask',
    index,
    polygon,
    label: 'Ignored',
    cursor: 'pointer',
    begin,
    clickTwice: () => {},
    path: [...corners, corners[0]],
    change: (by) => ({ polygon: polygon.map((p) => [p[0] + by[0], p[1] + by[1]]) }),
  };
}

/** Every corner, and the middle of every edge, out of which a new corner is pulled. */
function cornersOf(mask, corners) {
  const { index, polygon } = mask;
  return corners.flatMap((at, i) => {
    const next = (i + 1) % corners.length;
    const middle = [(at[0] + corners[next][0]) / 2, (at[1] + corners[next][1]) / 2];
    const between = [0, 1].map((k) => (polygon[i][k] + polygon[next][k]) / 2);
    const wider = [...polygon.slice(0, i + 1), between, ...polygon.slice(i + 1)];
    return [
      {
        key: `corner:${index}:${i}`,
        kind: 'corner',
        index,
        at,
        begin,
        clickTwice: () => deleteCorner(index, polygon, i),
        change: (by) => ({ polygon: moveCorner(polygon, i, by) }),
      },
      {
        key: `edge:${index}:${i}`,
        kind: 'edge',
        index,
        at: middle,
        reach: 9,
        begin,
        clickTwice: () => {},
        change: (by) => ({ polygon: moveCorner(wider, i + 1, by) }),
      },
    ];
  });
}

const moveCorner = (polygon, i, by) => polygon.map((p, k) => (k === i ? [p[0] + by[0], p[1] + by[1]] : p));

/** The mask whose inside lies under a place of the main view. */
export function maskAt(view, x, y) {
  if (view.name !== 'main') return null;
  const found = masksHere().find(({ polygon }) =>
    inside(
      polygon.map((p) => view.fromView(p)),
      x,
      y,
    ),
  );
  return found ?? null;
}

export function chooseMask(index) {
  setUi('mask', index);
}

export function deleteMask() {
  send({ do: 'delete_mask', index: ui.mask });
  setUi('mask', null);
}

/** A double click on a corner takes it away, as long as an area remains. */
function deleteCorner(index, polygon, corner) {
  if (polygon.length > 3) send({ do: 'change_mask', index, polygon: polygon.filter((_, i) => i !== corner) });
}

/** Begin to drag a target; `from` and `at` are pixels of the film. */
function begin(view, press, target, from) {
  const messageAt = (at) => ({
    do: 'change_mask',
    index: target.index,
    ...target.change([at[0] - from[0], at[1] - from[1]]),
  });
  beginDrag(view, press, messageAt, { target, hint: 'mask', gentle: true });
}

export function drawMasks(view, targets) {
  if (view.name !== 'main') return nothing;
  const corners = targets.filter(({ kind }) => kind === 'corner' || kind === 'edge');
  return svg`<g class="masks">
    ${masksHere().map((mask) => drawMask(view, mask, targets))}
    ${corners.map((target) => drawCorner(view, target))}
  </g>`;
}

function drawMask(view, mask, targets) {
  const chosen = mask.index === ui.mask ? 'chosen' : '';
  const target = targets.find(({ key }) => key === `mask:${mask.index}`);
  const hot = target && isHot(view, target) ? 'hot' : '';
  const corners = mask.polygon.map((p) => view.fromView(p));
  const d = pathOf(corners, true);
  return svg`<path class="mask-edge" d=${d} /><path class="mask-hatch" d=${hatch(corners)} />
    <path class="mask ${chosen} ${hot}" d=${d} data-mask=${mask.index} />`;
}

/** Slanting lines inside a polygon, where x + y is a multiple of the step. */
function hatch(corners) {
  const sums = corners.map(([x, y]) => x + y);
  let d = '';
  const first = Math.ceil(Math.min(...sums) / HATCH_PX) * HATCH_PX;
  for (let sum = first; sum < Math.max(...sums); sum += HATCH_PX) {
    const xs = corners.flatMap((a, i) => crossing(a, corners[(i + 1) % corners.length], sum));
    xs.sort((p, q) => p - q);
    for (let i = 0; i + 1 < xs.length; i += 2) {
      d += pathOf([
        [xs[i], sum - xs[i]],
        [xs[i + 1], sum - xs[i + 1]],
      ]);
    }
  }
  return d;
}

/** Where an edge crosses the line x + y = sum: its x, or nothing. */
function crossing(a, b, sum) {
  const [from, to] = [a[0] + a[1] - sum, b[0] + b[1] - sum];
  if (from > 0 === to > 0) return [];
  return [a[0] + ((b[0] - a[0]) * from) / (from - to)];
}

function drawCorner(view, target) {
  const state = `${isDragged(target) ? 'dragged' : ''} ${isHot(view, target) ? 'hot' : ''}`;
  const [x, y] = target.at;
  const r = target.kind === 'corner' ? 5 : 3;
  return svg`<circle class="corner ${target.kind} ${state}" cx=${x} cy=${y} r=${r} data-grip=${target.key} />`;
}
