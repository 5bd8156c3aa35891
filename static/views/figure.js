// The body over the film, painted by the page itself: what viser's camera view shows, from what the
// page knows. Which of both draws it is known here.

import { bodies } from '../store/bodies.js';
import { inBrowser } from '../store/storage.js';
import { server, setUi, ui } from '../store/state.js';
import { farthestFirst, css, outlined, paintLines, paintPart, towardWhite } from './painting.js';
import { drawsBy } from './software.js';

/** @typedef {import('./painting.js').Rgb} Rgb */

const KEPT = 'keypose.painted';
// Colours, widths and shares as app/scene and iframe.js have them for viser.
const [LINE_PX, SELECTED_LINE_PX, GHOST_PX] = [1.5, 2.5, 1];
const LINE_SHARE = 0.45;
const GHOST_OPACITY = 0.75;
/** What is selected keeps so much of its colour as wires, and is so much denser else. */
const SELECTED_OPACITY = 0.12;
/** Of a dash of what comes after the present frame, and of the gap after it. */
const DASH_M = 0.015;
const LEAST_DASH_PX = 2;
/** @type {Rgb} */
const WHITE = [255, 255, 255];
/** Of the keyframe before, of the one after, and of a soft one's own pose. */
const GHOSTS = /** @type {Rgb[]} */ ([
  [134, 217, 147],
  [217, 213, 199],
  [240, 186, 96],
]);
/** Of the body that new sizes are compared with. */
const BEFORE = /** @type {Rgb} */ ([226, 226, 230]);
/** Where the style sheet has the colours of parts by their side, and of what is selected. */
const TOKENS = { L: '--bL', R: '--bR', C: '--bC', selected: '--bS' };
/** @type {Record<string, Rgb>} */
const COLOURS = {};

/** As the person chose, else as the browser's 3D is: hardware draws it, software does not. */
export function mountFigure() {
  const style = getComputedStyle(document.documentElement);
  for (const [name, token] of Object.entries(TOKENS)) COLOURS[name] = rgbOf(style.getPropertyValue(token).trim());
  const chosen = inBrowser.read(KEPT);
  setUi('painted', drawsBy() === 'none' || (chosen === null ? drawsBy() === 'software' : chosen === 'yes'));
}

/** @param {string} hex  "#6fb4ff" @returns {Rgb} */
const rgbOf = (hex) => /** @type {Rgb} */ ([1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)));

export function togglePainted() {
  inBrowser.write(KEPT, ui.painted ? 'no' : 'yes');
  setUi('painted', !ui.painted);
}

/** A browser that draws no 3D leaves nothing to choose. */
export const whyPainted = () => (ui.flat ? 'WebGL is off' : '');

/**
 * Paint what there is to see; whether there was a body.
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./view.js').View} view
 */
export function paintFigure(ctx, view) {
  const { pose, solids } = server;
  if (!pose || !solids || !server.body || !server.view || !server.camera) return false;
  const project = (p) => view.project(p);
  const isParallel = server.camera.projection === 'telephoto';
  const seen = (of, T) => outlined(of, T, project, isParallel);
  const parts = [
    ...inLooks(ctx, seen(solids, pose.T)),
    ...beside(ctx, seen),
    ...(server.ghosts ?? []).flatMap(({ T }, i) =>
      seenThrough(seen(solids, T), css(GHOSTS[i], GHOST_OPACITY), GHOST_PX),
    ),
    ...(server.before ? seenThrough(seen(server.before.solids, server.before.T), css(BEFORE), LINE_PX) : []),
  ];
  for (const { paint } of farthestFirst(parts)) paint();
  paintTrail(ctx, view);
  return true;

  function seenThrough(outlines, colour, width) {
    return outlines.map((part) => ({ ...part, paint: () => paintLines(ctx, part, colour, width) }));
  }
}

/**
 * Paint the body alone as another camera sees it; whether there was one.
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('./painting.js').Project} project
 * @param {number[]} T_film_camera  Three rows of four.
 * @param {Record<string, number[]> | undefined} parts  T_camera_part of each part.
 * @param {boolean} isParallel
 */
export function paintBody(ctx, project, T_film_camera, parts, isParallel) {
  const { solids, body, view } = server;
  if (!parts || !solids || !body || !view) return false;
  const T = Object.fromEntries(Object.entries(parts).map(([name, each]) => [name, after(T_film_camera, each)]));
  for (const { paint } of farthestFirst(inLooks(ctx, outlined(solids, T, project, isParallel)))) paint();
  return true;
}

/** Parts of the bodies that are not posed, each in its own colour. */
function beside(ctx, seen) {
  const { solids_beside: solids = {}, poses_beside: poses = {} } = server;
  return bodies().flatMap(({ id, colour }) => {
    if (!solids[id] || !poses[id]) return [];
    const look = lookIn(rgbOf(colour), false);
    return seen(solids[id], poses[id]).map((part) => ({ ...part, paint: () => paintPart(ctx, part, look) }));
  });
}

/** Parts of the body with how each is painted. @param {import('./painting.js').Outlined[]} parts */
function inLooks(ctx, parts) {
  const looks = Object.fromEntries(server.body.parts.map(({ name, side }) => [name, lookOf(name, side)]));
  return parts.map((part) => ({ ...part, paint: () => paintPart(ctx, part, looks[part.name]) }));
}

/** One transform after another, each three rows of four. @param {number[]} A @param {number[]} B */
function after(A, B) {
  return [0, 4, 8].flatMap((row) =>
    [0, 1, 2, 3].map((k) => A[row] * B[k] + A[row + 1] * B[4 + k] + A[row + 2] * B[8 + k] + (k === 3 ? A[row + 3] : 0)),
  );
}

/** @returns {import('./painting.js').Look} */
function lookOf(name, side) {
  const isSelected = name === server.view.selected;
  return lookIn(isSelected ? COLOURS.selected : COLOURS[side], isSelected);
}

/** @param {Rgb} colour @param {boolean} isSelected @returns {import('./painting.js').Look} */
function lookIn(colour, isSelected) {
  const { mode, opacity } = server.view;
  const dense = Math.min(1, opacity + (isSelected ? SELECTED_OPACITY : 0));
  const thin = isSelected ? SELECTED_OPACITY : 0;
  return {
    colour,
    opacity: mode === 'wire' ? thin : dense,
    isWired: mode !== 'solid',
    line: isSelected ? WHITE : towardWhite(colour, LINE_SHARE),
    width: isSelected ? SELECTED_LINE_PX : LINE_PX,
  };
}

/** The way of the selected part's end: whole up to the present frame, dashed after it. */
function paintTrail(ctx, view) {
  const { trail } = server;
  if (!trail) return;
  const { frame } = server.view;
  /** @param {number[]} point  Its frame comes first. */
  const away = (point) => Math.abs(point[0] - frame);
  const present = trail.points.reduce((best, point, i) => (away(point) < away(trail.points[best]) ? i : best), 0);
  const points = trail.points.map(([, ...p]) => p);
  ctx.strokeStyle = css(WHITE);
  ctx.lineWidth = LINE_PX;
  line(ctx, view, points.slice(0, present + 1));
  const dash = Math.max(DASH_M * view.pxPerMetre(points[present]), LEAST_DASH_PX);
  ctx.lineCap = 'butt';
  ctx.setLineDash([dash, dash]);
  line(ctx, view, points.slice(present));
  ctx.setLineDash([]);
}

function line(ctx, view, points) {
  ctx.beginPath();
  let wasSeen = false;
  for (const p of points) {
    const [x, y, depth] = view.project(p);
    if (depth > 0) wasSeen ? ctx.lineTo(x, y) : ctx.moveTo(x, y);
    wasSeen = depth > 0;
  }
  ctx.stroke();
}
