// The curve of the selected part about one axis, the error thin below it, and its scale:
// degrees up, pixels down.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { shortNumber } from '../../controls/arithmetic.js';
import { onEnter } from '../../controls/focus.js';
import { server, setUi, ui } from '../../store/state.js';
import { partNamed } from '../../store/parts.js';
import { extent, line, numbers, memoize, runsOf } from './series.js';
import { frameCount } from '../../store/clip.js';
import { GUTTER, right, x } from './scale.js';
import { keyFrames } from '../../actions/playhead.js';

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
/** States whose frames are shown as they were, not as they will be. */
const STALE = ['outdated', 'waiting', 'none'];
const ERROR_SHARE = 0.72;

/** While a key of the curve is dragged its scale stands still: {low, high}. */
let frozen = null;

export function freezeRange(on) {
  frozen = on ? range() : null;
}

const range = () => rangeOf(server.curve?.[axis()]);

export const hasCurve = () => anyAngle(server.curve);

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

export const chooseAxis = (name) => setUi('curveAxis', name);

export function scale(row) {
  const ends = frozen ?? range();
  return ends === null ? null : scaleOf(ends, row);
}

export const valueAt = (at) => server.curve?.[axis()]?.[at] ?? null;

/** The whole chart without its keys. */
export function drawCurve(row) {
  if (row === null || !hasCurve() || frameCount() === 0) return nothing;
  const at = scale(row);
  const error = svg`<path class="error" d=${errorLine(row)} />`;
  if (at === null) return error;
  const values = server.curve[axis()] ?? [];
  return svg`<path class="s-line"
    d=${at.ticks.map((value) => `M${GUTTER} ${at.y(value).toFixed(1)}H${right() + 26}`).join('')} />
    ${error}
    ${pieces().map(
      ({ first, last, stale }) => svg`
      <path class=${`angle ${axis()}${stale ? ' stale' : ''}`}
        d=${runsOf(values, first, last)
          .map((run) => line(run, at.y))
          .join('')} />`,
    )}
    <path class=${`between ${axis()}`} d=${between(at)} />`;
}

/** Stretches of frames drawn alike: neighbouring segments of one kind are one stretch. */
function pieces() {
  const result = [];
  const add = (last, stale) => {
    const before = result.at(-1);
    if (before?.stale === stale) before.last = last;
    else if (last > (before?.last ?? 0)) result.push({ first: before?.last ?? 0, last, stale });
  };
  const segments = server.segments ?? [];
  if (segments.length) add(segments[0].first, true);
  for (const s of segments) add(s.last, STALE.includes(s.state));
  add(frameCount() - 1, true);
  return result;
}

const largest = memoize((list) => extent(numbers(list))?.high ?? 0);

export const hasError = () => largest(server.curve?.error) > 0;

function errorLine(row) {
  const most = largest(server.curve.error);
  if (most <= 0) return '';
  const y = (value) => row.y + row.h - (value / most) * (row.h - 14) * ERROR_SHARE;
  return runsOf(server.curve.error)
    .map((run) => line(run, y))
    .join('');
}

/** Straight lines from key to key where nothing between them is known. */
function between(at) {
  const keys = curveKeys();
  const open = (key, i) => i > 0 && key - keys[i - 1] > 1 && valueAt(key - 1) === null;
  const lines = keys.map((key, i) =>
    open(key, i) ? `M${x(keys[i - 1])} ${at.y(valueAt(keys[i - 1]))}L${x(key)} ${at.y(valueAt(key))}` : '',
  );
  return lines.join('');
}

export const curveKeys = () => keyFrames().filter((at) => valueAt(at) !== null);

const PITCH = 14;

const LETTER_PX = 6.2;

/** Left of the curve: whose it is, about which axis, and the numbers of its scale. */
export function drawCurveLabels(row) {
  if (row === null || !hasCurve()) return nothing;
  const part = partNamed(server.curve.part);
  const name = part?.label ?? server.curve.part;
  const at = scale(row);
  const top = row.y + (row.h > 34 ? 14 : 12);
  const ticks = (at?.ticks ?? []).filter((value) => hasRoom(value, at.y(value), row, name));
  return svg`<text class="lbl" x="12" y=${top}>${name}</text>
    ${row.h > 34 ? drawAxes(part, top + 15) : nothing}
    ${row.h > 46 && hasError() ? drawErrorLabel(row) : nothing}
    ${ticks.map(
      (value) => svg`<text class="d" x=${GUTTER - 8} y=${at.y(value) + 4}
      text-anchor="end">${shortNumber(value, 0)}</text>`,
    )}`;
}

/** A number stands beside the name of the part only where the name is short enough. */
function hasRoom(value, y, row, name) {
  const nameEnds = 12 + LETTER_PX * name.length;
  return y > row.y + 22 || nameEnds < GUTTER - 12 - LETTER_PX * String(value).length;
}

function drawErrorLabel(row) {
  const y = row.y + 44;
  return svg`<text class="d" x="12" y=${y}>Error</text><path class="error" d=${`M44 ${y - 4}h16`} />`;
}

/** "X Y Z Bend": the letters choose the axis, the word says what turning about it does. */
function drawAxes(part, y) {
  const word = part?.words?.[axis()] ?? '';
  return svg`<g role="radiogroup" aria-label="Axis of the curve">
      ${AXES.map((name, i) => drawLetter(name, 12 + i * PITCH, y, part))}</g>
    <text x=${12 + 3 * PITCH + 2} y=${y}>${word}</text>`;
}

function drawLetter(name, px, y, part) {
  const word = part?.words?.[name] ?? '';
  const chosen = axis() === name;
  return svg`<g class=${`axis ${name}${chosen ? ' chosen' : ''}`} role="radio" tabindex="0"
      aria-checked=${String(chosen)} aria-label=${`${name.toUpperCase()} ${word}`}
      @click=${() => chooseAxis(name)} @keydown=${onEnter(() => chooseAxis(name))}>
    <title>${name.toUpperCase()} ${word}, degrees</title>
    <rect x=${px - 4} y=${y - 13} width=${PITCH + 1} height="18" rx="3" />
    <text x=${px} y=${y}>${name.toUpperCase()}</text></g>`;
}
