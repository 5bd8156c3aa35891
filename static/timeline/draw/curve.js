// The curve of the selected part about one axis, with its keys, the error thin below it, and its scale:
// degrees up, pixels down.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../../store/state.js';
import { partNamed } from '../../store/parts.js';
import { extent, line, numbers, memoize, runsOf } from './series.js';
import { frameCount } from '../../store/clip.js';
import { GUTTER, right, x } from './scale.js';
import { diamond, nearest, withRoom } from './keymarks.js';
import { frame, isKey, keyFrames } from '../../actions/playhead.js';

const STEPS = [1, 2, 5, 10, 15, 20, 30, 45, 60, 90, 180, 360];
const LEAST_SPAN = 20;
const TICKS_APART_PX = 15;
const MOST_TICKS = 6;
const MARGIN = 6;

/** The range of a series with some air: {low, high}; null without values. */
export const rangeOf = memoize((list) => {
  const found = extent(numbers(list));
  if (found === null) return null;
  const { low, high } = found;
  const missing = Math.max(0, LEAST_SPAN - (high - low)) / 2;
  const air = 0.06 * (high - low);
  return { low: low - missing - air, high: high + missing + air };
});

/** How a range lies on the rows of the curve: y(value), value(y), ticks. */
export function scaleOf({ low, high }, row) {
  const room = Math.max(1, row.h - 2 * MARGIN);
  const top = row.y + MARGIN;
  const perPx = (high - low) / room;
  const apart = Math.max(TICKS_APART_PX, room / MOST_TICKS);
  const step = STEPS.find((s) => s / perPx >= apart) ?? STEPS.at(-1);
  const ticks = [];
  for (let at = Math.ceil(low / step) * step; at <= high; at += step) ticks.push(at);
  return {
    y: (value) => top + (high - value) / perPx,
    value: (y) => high - (y - top) * perPx,
    ticks,
  };
}

const AXES = ['x', 'y', 'z'];
const KEY_RADIUS = 4.5;
/** States whose frames are shown as they were, not as they will be. */
const STALE = ['outdated', 'waiting', 'none'];
const ERROR_SHARE = 0.72;

/** While a key of the curve is dragged its scale stands still: {low, high}. */
let frozen = null;

export function freezeRange(on) {
  frozen = on ? range() : null;
}

function range() {
  return rangeOf(server.curve?.[axis()]);
}

export function hasCurve() {
  return anyAngle(server.curve);
}

/** One value alone, of a single key, is no curve yet. */
const anyAngle = memoize((curve) =>
  AXES.some((name) => numbers(curve?.[name]).filter((value) => value === value).length > 1),
);

/** The axis shown: the one chosen, else the first the tracker follows on this part. */
export function axis() {
  if (ui.curveAxis) return ui.curveAxis;
  const tracked = partNamed(server.curve?.part)?.tracked ?? [];
  return AXES.find((name) => tracked.includes(`r${name}`)) ?? 'x';
}

export function chooseAxis(name) {
  setUi('curveAxis', name);
}

export function scale(row) {
  const ends = frozen ?? range();
  return ends === null ? null : scaleOf(ends, row);
}

export function valueAt(at) {
  return server.curve?.[axis()]?.[at] ?? null;
}

/** The whole chart; `without` is the key that is being dragged and drawn elsewhere. */
export function drawCurve(row, without) {
  if (row === null || !hasCurve() || frameCount() === 0) return nothing;
  const at = scale(row);
  const values = server.curve[axis()] ?? [];
  return svg`${drawGrid(row, at)}
    <path class="error" d=${errorLine(row)} />
    ${at === null ? nothing : pieces().map(({ first, last, stale }) => svg`
      <path class=${`angle ${axis()}${stale ? ' stale' : ''}`}
        d=${runsOf(values, first, last).map((run) => line(run, at.y)).join('')} />`)}
    ${at === null ? nothing : svg`<path class=${`between ${axis()}`} d=${between(at)} />`}
    ${at === null ? nothing : drawCurveKeys(at, without)}`;
}

function drawGrid(row, at) {
  if (at === null) return nothing;
  return svg`<path class="s-line" d=${at.ticks
    .map((value) => `M${GUTTER} ${at.y(value).toFixed(1)}H${right() + 26}`).join('')} />`;
}

/** Stretches of frames drawn alike: neighbouring segments of one kind are one stretch. */
function pieces() {
  const result = [];
  const add = (first, last, stale) => {
    const before = result.at(-1);
    if (before && before.stale === stale) before.last = last;
    else if (last > first) result.push({ first, last, stale });
  };
  const segments = server.segments ?? [];
  const end = frameCount() - 1;
  if (segments.length === 0) return [{ first: 0, last: end, stale: true }];
  add(0, segments[0].first, true);
  for (const s of segments) add(s.first, s.last, STALE.includes(s.state));
  add(segments.at(-1).last, end, true);
  return result;
}

const largest = memoize((list) => extent(numbers(list))?.high ?? 0);

export function hasError() {
  return largest(server.curve?.error) > 0;
}

function errorLine(row) {
  const most = largest(server.curve.error);
  if (most <= 0) return '';
  const y = (value) => row.y + row.h - (value / most) * (row.h - 14) * ERROR_SHARE;
  return runsOf(server.curve.error).map((run) => line(run, y)).join('');
}

/** Straight lines from key to key where nothing between them is known. */
function between(at) {
  const keys = curveKeys();
  const open = (key, i) => i > 0 && key - keys[i - 1] > 1 && valueAt(key - 1) === null;
  const lines = keys.map((key, i) => (open(key, i)
    ? `M${x(keys[i - 1])} ${at.y(valueAt(keys[i - 1]))}L${x(key)} ${at.y(valueAt(key))}`
    : ''));
  return lines.join('');
}

function curveKeys() {
  return keyFrames().filter((at) => valueAt(at) !== null);
}

function drawCurveKeys(at, without) {
  // Where keys stand too close for diamonds, the keyframe row shows them well enough.
  const marks = withRoom(curveKeys()).filter((key) => key !== without);
  const mark = (key) => diamond(x(key).toFixed(1), at.y(valueAt(key)), KEY_RADIUS);
  return svg`<path class="curvekey" d=${marks.map(mark).join('')} />`;
}

/** The current key's diamond on the curve, in the accent. */
export function drawCurrentCurveKey(row) {
  if (row === null || !hasCurve() || !isKey(frame())) return nothing;
  const at = scale(row);
  const value = valueAt(frame());
  if (at === null || value === null) return nothing;
  return svg`<path class="curvekey current" d=${diamond(x(frame()), at.y(value), KEY_RADIUS)} />`;
}

/** The key whose diamond on the curve is at this place, or null. */
export function curveKeyNear(row, px, py) {
  const at = row === null ? null : scale(row);
  if (at === null || px < GUTTER) return null;
  const keys = withRoom(curveKeys());
  const close = keys.filter((key) => Math.abs(at.y(valueAt(key)) - py) <= 9);
  return nearest(close, px, 9);
}
