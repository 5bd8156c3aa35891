// The body as a painter draws it, on a flat canvas: solids from far to near, each covering what lies
// behind it, in the colours and the light of viser's picture. For browsers whose 3D is software.

import { dot, plus } from './orbit.js';
import { hull, placed } from './floor.js';

/** @typedef {[number, number, number]} Rgb  0 to 255. */
/** @typedef {(p: number[]) => number[]} Project  From the camera frame to pixels, and the depth. */
/**
 * @typedef {object} Outlined  One part as it is seen.
 * @property {string} name
 * @property {number[][]} hull  Its outline, pixels.
 * @property {number[][][]} flats  Outlines of its flat sides that face the eye.
 * @property {number[][]} normals  Of these, in the camera frame.
 * @property {number[][][]} hidden  Outlines of those that do not.
 * @property {number[][][]} wires  Lines along its round side, seen from the eye.
 * @property {[number[], number[]]} axis  Both ends of it along y, pixels and depth.
 * @property {number[]} along  Its y axis in the camera frame.
 * @property {number} half_m  Half its width.
 * @property {number[]} box  Left, top, right, bottom.
 */
/**
 * @typedef {object} Look
 * @property {Rgb} colour
 * @property {number} opacity  Of its surface; its lines are opaque.
 * @property {boolean} isWired
 * @property {Rgb} line
 * @property {number} width
 */

const NEAR_M = 0.05;

// --- what is seen of parts

/**
 * Every part standing so that lies before the eye.
 * @param {Record<string, import('../store/shapes.js').Solid>} solids
 * @param {Record<string, number[]>} T
 * @param {Project} project
 * @param {boolean} isParallel  Rays to the camera are.
 * @returns {Outlined[]}
 */
export function outlined(solids, T, project, isParallel) {
  return Object.keys(solids)
    .filter((name) => T[name])
    .map((name) => partSeen(name, solids[name], T[name], project, isParallel))
    .filter((part) => part.hull.length > 2);
}

/**
 * @param {import('../store/shapes.js').Solid} solid
 * @param {number[]} T
 * @param {Project} project
 * @returns {Outlined}
 */
function partSeen(name, solid, T, project, isParallel) {
  const screen = (points) => hull(points.map(project).filter(([, , depth]) => depth > NEAR_M));
  const turned = ([x, y, z]) => [
    T[0] * x + T[1] * y + T[2] * z,
    T[4] * x + T[5] * y + T[6] * z,
    T[8] * x + T[9] * y + T[10] * z,
  ];
  const isFacing = (normal, p) => (isParallel ? normal[2] : dot(normal, p)) < 0;
  const flats = solid.flats.map(({ points, normal }) => ({ at: placed(points, T), normal: turned(normal) }));
  const facing = flats.filter(({ at, normal }) => isFacing(normal, at[0]));
  const wires = solid.wires
    .map(({ ends, normal }) => ({ at: placed(ends, T), normal: turned(normal) }))
    .filter(({ at, normal }) => isFacing(normal, at[0]) && at.every(([, , z]) => z > NEAR_M));
  const outline = screen(placed(solid.points, T));
  return {
    name,
    hull: outline,
    flats: facing.map(({ at }) => screen(at)),
    normals: facing.map(({ normal }) => normal),
    hidden: flats.filter((flat) => !facing.includes(flat)).map(({ at }) => screen(at)),
    wires: wires.map(({ at }) => at.map(project)),
    ...axisOf(solid.points, T, project),
    along: [T[1], T[5], T[9]],
    box: boxOf(outline),
  };
}

/** @returns {{ axis: [number[], number[]], half_m: number }} */
function axisOf(points, T, project) {
  const ranges = [0, 1, 2].map((k) => [Math.min(...points.map((p) => p[k])), Math.max(...points.map((p) => p[k]))]);
  const [x, , z] = ranges.map(([low, high]) => (low + high) / 2);
  const [a, b] = placed(
    ranges[1].map((y) => [x, y, z]),
    T,
  ).map(project);
  return { axis: [a, b], half_m: (ranges[0][1] - ranges[0][0] + ranges[2][1] - ranges[2][0]) / 4 };
}

function boxOf(points) {
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

// --- what covers what

/**
 * The parts in an order in which each may cover those before it.
 * @template {Outlined} P
 * @param {P[]} parts
 * @returns {P[]}
 */
export function farthestFirst(parts) {
  const left = [...parts].sort((a, b) => meanDepth(b) - meanDepth(a));
  const ordered = [];
  while (left.length) {
    const free = left.findIndex((part) => left.every((other) => other === part || !covers(part, other)));
    ordered.push(...left.splice(Math.max(free, 0), 1)); // parts that cover each other in a ring: the farthest
  }
  return ordered;
}

/** @param {Outlined} part */
const meanDepth = ({ axis: [a, b] }) => (a[2] + b[2]) / 2;

/** Whether a part lies before another where both are seen. */
function covers(part, other) {
  const [a, b] = [part.box, other.box];
  const [left, top] = [Math.max(a[0], b[0]), Math.max(a[1], b[1])];
  const [right, bottom] = [Math.min(a[2], b[2]), Math.min(a[3], b[3])];
  if (left >= right || top >= bottom) return false;
  const middle = [(left + right) / 2, (top + bottom) / 2];
  return frontAt(part, middle) < frontAt(other, middle);
}

/**
 * The depth of a part's surface at the place of its axis that is nearest on the screen.
 * @param {Outlined} part
 * @param {number[]} at
 */
function frontAt({ axis: [a, b], half_m }, [x, y]) {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const share = ((x - a[0]) * dx + (y - a[1]) * dy) / Math.max(dx * dx + dy * dy, 1e-9);
  const at = Math.min(Math.max(share, 0), 1);
  // Along a line it is the inverse of the depth that goes evenly over the screen.
  return 1 / ((1 - at) / Math.max(a[2], NEAR_M) + at / Math.max(b[2], NEAR_M)) - half_m;
}

// --- light, as the scene of viser has it (app/scene)

const TO_LIGHT = unit([-0.5, -0.7, -0.75]);
const SKY = 2.0;
const SUN = 1.6;
const GROUND = [92, 96, 106].map(linear);
const STOPS = [-1, -0.5, 0, 0.5, 1];

/**
 * The colour of a surface with this normal in the camera frame.
 * @param {Rgb} colour
 * @param {number[]} normal
 * @returns {Rgb}
 */
export function lit(colour, normal) {
  const towards = dot(normal, TO_LIGHT);
  const share = 0.5 * towards + 0.5;
  return /** @type {Rgb} */ (
    colour.map((value, k) => {
      const light = SKY * (GROUND[k] * (1 - share) + share) + SUN * Math.max(towards, 0);
      return encoded((linear(value) * light) / Math.PI);
    })
  );
}

/** @param {number} value */
function linear(value) {
  const v = value / 255;
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
}

function encoded(value) {
  const v = Math.min(value, 1);
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

/** @param {number[]} v */
function unit(v) {
  const length = Math.hypot(...v);
  return v.map((value) => value / length);
}

/** @param {number[]} one @param {number[]} other */
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];

// --- paint

export const css = ([r, g, b], alpha = 1) => `rgba(${r},${g},${b},${alpha})`;

/** @param {Rgb} colour @param {number} share @returns {Rgb} */
export const towardWhite = (colour, share) =>
  /** @type {Rgb} */ (colour.map((v) => Math.round(v * (1 - share) + 255 * share)));

const WIRE_SHARE = 0.3;
const WIRE_OPACITY = 0.38;

/**
 * Paint a part over what lies behind it.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Outlined} part
 * @param {Look} look
 */
export function paintPart(ctx, part, look) {
  ctx.lineJoin = ctx.lineCap = 'round';
  cover(ctx, part.hull, look.opacity && sideOf(ctx, part, look));
  part.flats.forEach((flat, i) =>
    cover(ctx, flat, look.opacity && css(lit(look.colour, part.normals[i]), look.opacity)),
  );
  if (look.isWired) strokeLines(ctx, part.wires, false, css(towardWhite(look.colour, WIRE_SHARE), WIRE_OPACITY), 1);
  strokeLines(ctx, [part.hull, ...part.flats], true, css(look.line), look.width);
}

/**
 * All lines of a part that lets everything be seen through it.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Outlined} part
 */
export function paintLines(ctx, part, colour, width) {
  ctx.lineJoin = ctx.lineCap = 'round';
  strokeLines(ctx, [part.hull, ...part.flats, ...part.hidden], true, colour, width);
}

/** Put a colour, or nothing, in the place of what was there. */
function cover(ctx, corners, fill) {
  trace(ctx, [corners], true);
  ctx.globalCompositeOperation = 'destination-out';
  ctx.fillStyle = '#000';
  ctx.fill();
  ctx.globalCompositeOperation = 'source-over';
  if (!fill) return;
  ctx.fillStyle = fill;
  ctx.fill();
}

function strokeLines(ctx, lines, isClosed, colour, width) {
  trace(ctx, lines, isClosed);
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.stroke();
}

function trace(ctx, lines, isClosed) {
  ctx.beginPath();
  for (const line of lines) {
    line.forEach(([x, y], i) => (i ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
    if (isClosed) ctx.closePath();
  }
}

/**
 * The round side: light from one edge of it to the other.
 * @param {CanvasRenderingContext2D} ctx
 * @param {Outlined} part
 * @param {Look} look
 */
function sideOf(ctx, { axis: [a, b], along, hull: corners }, { colour, opacity }) {
  const middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
  const [x, y, z] = along;
  const sight = [0, 0, -1];
  const slope = Math.hypot(x, y);
  // Seen along its own axis it has no side.
  if (slope < 1e-3) return css(lit(colour, sight), opacity);
  const right = [y / slope, -x / slope, 0];
  const front = unit(cross(right, along)[2] < 0 ? cross(right, [x, y, z]) : cross([x, y, z], right));
  const reach = Math.max(
    ...corners.map(([u, v]) => Math.abs((u - middle[0]) * right[0] + (v - middle[1]) * right[1])),
    1,
  );
  const [dx, dy] = [right[0] * reach, right[1] * reach];
  const gradient = ctx.createLinearGradient(middle[0] - dx, middle[1] - dy, middle[0] + dx, middle[1] + dy);
  for (const stop of STOPS) {
    const normal = plus(
      right.map((v) => v * stop),
      front,
      Math.sqrt(1 - stop * stop),
    );
    gradient.addColorStop((stop + 1) / 2, css(lit(colour, normal), opacity));
  }
  return gradient;
}
