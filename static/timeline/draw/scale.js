// Where everything stands: frames across, and which of them are shown; from the top down ruler,
// keyframes, lanes and curve.

import { clamp } from '../../controls/arithmetic.js';
import { leastSpan, setRoom, showFrames, shown } from '../../actions/window.js';

export const GUTTER = 128;
/** Of a segment between its keys, above and below its middle. */
export const BAR = { half: 6 };
const LEFT = GUTTER + 10;
const MARGIN_RIGHT = 26;

let width = 0;

export function setWidth(px) {
  width = px;
  setRoom(right() - LEFT);
}

export function right() {
  return Math.max(LEFT + 1, width - MARGIN_RIGHT);
}

/** The frames with any pixel on the drawing: the margins beside the window show some more. */
export function visible() {
  return { first: frameAt(GUTTER), last: frameAt(right() + MARGIN_RIGHT) };
}

/** Of some frames, or of what has a frame or a first and a last one, what has any pixel on the drawing. */
export function seenOf(things) {
  const { first, last } = visible();
  return things.filter(
    (each) => (each.last ?? each.frame ?? each) >= first - 1 && (each.first ?? each.frame ?? each) <= last + 1,
  );
}

export function left() {
  return LEFT;
}

export function pxPerFrame() {
  const { first, last } = shown();
  return (right() - LEFT) / Math.max(last - first, 1e-9);
}

/** Where a frame stands, in pixels; a clip of one frame stands at the left end. */
export function x(frame) {
  const { first, last } = shown();
  return last > first ? LEFT + ((frame - first) * (right() - LEFT)) / (last - first) : LEFT;
}

/** The frame at a pixel, not rounded and not kept within the clip. */
export function frameAt(px) {
  const { first, last } = shown();
  return first + ((px - LEFT) * (last - first)) / (right() - LEFT);
}

/** The nearest of some frames within so many pixels, or null. */
export function nearest(frames, px, reach) {
  let best = null;
  let least = reach;
  for (const at of frames) {
    const apart = Math.abs(x(at) - px);
    if (apart <= least) [best, least] = [at, apart];
  }
  return best;
}

/** That frame as what is hit: {frame}. */
export function hitNear(frames, px, reach) {
  const frame = nearest(frames, px, reach);
  return frame === null ? null : { frame };
}

const SNAP_PX = 4;

/** The frame meant at a pixel: one of some frames within 4 px, else the one there. */
export const snapped = (px, frames) => nearest(frames, px, SNAP_PX) ?? frameAt(px);

/** Zoom by a factor; the frame under this pixel stays where it is. */
export function zoomAt(px, factor) {
  const { first, last } = shown();
  const share = clamp((px - LEFT) / (right() - LEFT), 0, 1);
  const fixed = first + share * (last - first);
  const span = Math.max(leastSpan(), (last - first) / factor);
  showFrames(fixed - share * span, fixed + (1 - share) * span);
}

/** Of all steps 1, 2, 5, 10, ... frames the smallest whose marks stand at least so far apart. */
export function rulerStep(leastPx) {
  const least = leastPx / pxPerFrame();
  let step = 1;
  while (step < least) {
    const digit = Number(String(step)[0]);
    step *= digit === 2 ? 2.5 : 2;
  }
  return step;
}

export const RULER = 22;
export const OVERVIEW = 6;
const KEYS = 34;
const GAP = 4;
const LANE = { least: 14, most: 22, weakest: 18 };
const CURVE_LEAST = 40;
const ROOM_FOR_LANES = 80;
const PINS = { full: 30, thin: 3, gap: 2 };
const CAMERA = { full: 22, low: 16 };

/**
 * Rows of a drawing `height` px high with `lanes` lanes; `weakest` says the one lane stands alone;
 * `pins` whether some are to be shown: in a row, or beside the weakest part's lane as a thin line; `camera`
 * whether its motion has a row; `bodies` and `films` how high the rows of other bodies and films are, 0
 * without any.
 * Lanes that do not fit are scrolled (`lanes.room` < `lanes.full`); a low drawing drops its curve.
 */
export function rowsFor({ height, zoomed, lanes, weakest, pins = false, camera = false, bodies = 0, films = 0 }) {
  const top = RULER + (zoomed ? OVERVIEW : 0);
  const keys = { y: top, h: KEYS, middle: top + KEYS / 2 };
  const bodiesRow = bodies ? { y: top + KEYS, h: bodies } : null;
  const cameraRow = camera ? { y: top + KEYS + bodies, h: weakest ? CAMERA.low : CAMERA.full } : null;
  const filmsTop = top + KEYS + bodies + (cameraRow?.h ?? 0);
  const filmsRow = films ? { y: filmsTop, h: films } : null;
  const below = filmsTop + films;
  const forPins = pins ? (weakest ? PINS.thin : PINS.full) + PINS.gap : 0;
  const room = Math.max(0, height - below - forPins);
  const each = laneHeight(room, lanes, weakest);
  const full = lanes * each;
  const forLanes = lanes === 0 ? 0 : Math.max(0, Math.min(full, room - CURVE_LEAST - 16, room - GAP));
  // Whole lanes only, one at least: half a lane reads as a low one.
  const whole = lanes === 0 ? 0 : Math.max(1, Math.floor(forLanes / each)) * each;
  const seen = Math.min(whole, Math.max(0, room - GAP));
  const laneRow = { y: below + GAP, each, full, room: seen };
  const pinTop = lanes === 0 ? below + 1 : laneRow.y + seen + PINS.gap;
  const pinRow = pins ? { y: pinTop, h: weakest ? PINS.thin : PINS.full, thin: weakest } : null;
  const curveTop = (lanes === 0 ? below : laneRow.y + seen + 6) + forPins;
  const rest = height - curveTop - 6;
  const curve = rest >= 24 ? { y: curveTop, h: rest } : null;
  return {
    height,
    top,
    keys,
    bodies: bodiesRow,
    camera: cameraRow,
    films: filmsRow,
    lanes: laneRow,
    pins: pinRow,
    curve,
  };
}

/** Whether a row, where there is one, is at a height. */
export const isIn = (row, y) => row !== null && y >= row.y && y < row.y + row.h;

/** Whether a drawing this high has no room for more than the weakest part's lane. */
export function isCramped(height) {
  return height - RULER - KEYS < ROOM_FOR_LANES;
}

function laneHeight(room, lanes, weakest) {
  if (weakest) return LANE.weakest;
  // A tall timeline gives its lanes air, but never more than half of it.
  const fair = Math.floor((room * 0.5) / Math.max(1, lanes));
  return clamp(fair, LANE.least, LANE.most);
}
