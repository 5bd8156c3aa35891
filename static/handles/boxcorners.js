// The corners of a box that are seen: each is dragged to where the picture shows it, and stays there
// while others are. Of a body of few parts those of every box, else those of the selected part, if it is
// a thing: a person's hands and feet have handles of their own.

import { svg } from '../vendor/lit-html/lit-html.js';
import { partNamed } from '../store/parts.js';
import { server, ui } from '../store/state.js';
import { isDragged, isHot } from './interaction.js';
import { gripScale } from './scale.js';
import { add, axesOf, distance, dot, originOf, pathOf, times } from './space.js';

/** A body of more parts is too full of handles for the corners of all of them. */
const FEW_PARTS = 3;
const HALF_PX = 4.5;
const CROSS_PX = 7;
/** A press that lies so far beside a corner and on no other handle means the corner: it would move the
 * box, and let go of all corners that were placed. On a small box it is less. */
const BESIDE_PX = 24;
const BESIDE_SHARE = 0.3; // of the nearest edge, as it is seen
const BITS = [4, 2, 1];

/** The corners that can be dragged in a view: [{key, handle, at, part, label, …}]; over the picture alone. */
export function boxCornersIn(view) {
  if (view.name !== 'main' || ui.tool === 'size' || !server.pose || !view.eye) return [];
  const all = server.body.parts.length <= FEW_PARTS;
  return server.body.parts
    .filter((part) => part.corners_cm.length && (all || (part.name === server.view.selected && part.side === 'C')))
    .flatMap((part) => cornersOf(view, part));
}

function cornersOf(view, part) {
  const T = server.pose.T[part.name];
  if (!T) return [];
  const axes = axesOf(T);
  const points = part.corners_cm.map((cm) =>
    axes.reduce((sum, axis, k) => add(sum, times(axis, cm[k] / 100)), originOf(T)),
  );
  const rays = server.camera?.projection === 'telephoto' ? points.map(() => [0, 0, 1]) : points;
  const label = `${part.label} corner`;
  const spots = points.map((point) => view.project(point));
  return seenCorners(points, rays)
    .map((index) => {
      const [x, y] = spots[index];
      const handle = { kind: 'box_corner', part: part.name, index };
      return {
        key: `box-corner:${part.name}:${index}`,
        kind: 'box_corner',
        handle,
        part: part.name,
        label,
        limb: [part.name],
        point: points[index],
        at: [x, y],
        radius: HALF_PX * gripScale(view),
        beside: besideOf(spots, index),
        isRoot: !part.parent,
      };
    })
    .filter(({ at }) => Number.isFinite(at[0] + at[1]));
}

/**
 * How far beside a corner a press still means it, pixels.
 * @param {number[][]} spots  Of all eight corners.
 */
const besideOf = (spots, index) =>
  Math.min(BESIDE_PX, ...BITS.map((bit) => BESIDE_SHARE * distance(spots[index], spots[index ^ bit])));

/** The corner that a press means which lies on no handle; none where it lies beside none. */
export function cornerBeside(corners, x, y) {
  const near = corners.filter(({ at, beside }) => distance(at, [x, y]) <= beside);
  return near.sort((a, b) => distance(a.at, [x, y]) - distance(b.at, [x, y])).slice(0, 1);
}

/**
 * Which of the eight corners of a box lie on a side that faces the eye, x slowest and z fastest.
 * @param {number[][]} points  Where they are.
 * @param {number[][]} rays  The line of sight to each.
 */
export function seenCorners(points, rays) {
  return points.flatMap((point, i) => {
    // Each corner lies on three sides; the edge that leaves a side leads inward.
    const isSeen = BITS.some((bit) => dot(add(points[i ^ bit], point, -1), rays[i]) > 0);
    return isSeen ? [i] : [];
  });
}

export function drawBoxCorners(view, corners) {
  const placed = view.name === 'main' ? server.pose.corners : [];
  return svg`<g class="box-corners">
    ${placed.map((one) => drawPlaced(view, one))}
    ${corners.map((corner) => drawCorner(view, corner))}
  </g>`;
}

function drawCorner(view, corner) {
  const isPlaced = server.pose.corners.some(({ part, index }) => part === corner.part && index === corner.handle.index);
  const state = [isPlaced ? 'placed' : '', isDragged(corner) ? 'dragged' : '', isHot(view, corner) ? 'hot' : ''].join(
    ' ',
  );
  const half = corner.radius * (isDragged(corner) || isHot(view, corner) ? 1.33 : 1);
  const [x, y] = corner.at;
  return svg`<rect class="grip box-corner ${state}" x=${x - half} y=${y - half} width=${2 * half} height=${2 * half}
    data-grip=${corner.key} />`;
}

/** A cross where a corner was put: the box may not reach it, as where its sizes are others. */
function drawPlaced(view, { part, uv }) {
  if (!partNamed(part)) return svg``;
  const [x, y] = view.fromView(uv);
  const r = CROSS_PX * gripScale(view);
  return svg`<path class="placed-at" d="${pathOf([
    [x - r, y],
    [x + r, y],
  ])}${pathOf([
    [x, y - r],
    [x, y + r],
  ])}" />`;
}
