// Curves of many frames on few pixels. A series has one number per frame, NaN where there is none: what
// comes as a list with nulls is turned once into an array of numbers, over which even 200,000 frames
// are gone through within a frame. Where several frames share a pixel column its lowest and highest
// value stand for them: no more points are drawn than pixels, and a dip of one frame is still seen.

import { pxPerFrame, visible, x } from './scale.js';

const EMPTY = new Float32Array(0);
const known = new WeakMap();

/** The numbers of a list, or of nothing; the same list gives the same array again. */
export function numbers(list) {
  if (!list) return EMPTY;
  if (list instanceof Float32Array) return list;
  if (!known.has(list)) {
    known.set(
      list,
      Float32Array.from(list, (value) => value ?? NaN),
    );
  }
  return known.get(list);
}

/** Lowest and highest from one index to another (both included); null without any number. */
export function extent(values, from = 0, to = values.length - 1) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = from; i <= to; i += 1) {
    // A NaN is neither below nor above anything.
    if (values[i] < low) low = values[i];
    if (values[i] > high) high = values[i];
  }
  return low <= high ? { low, high } : null;
}

/** Remember the last result of a function while its arguments stay the same. */
export function memoize(compute) {
  let args = null;
  let result;
  return (...now) => {
    if (args === null || now.some((value, i) => !Object.is(value, args[i]))) {
      result = compute(...now);
      args = now;
    }
    return result;
  };
}

/**
 * The shown part of a series as runs without gaps: [[{x, low, high, frame}, ...], ...].
 * Missing values, and frames outside `first`..`last`, part the runs. While frames are wider than
 * a pixel, `low` and `high` are the same.
 */
export function runsOf(list, first = 0, last = Infinity) {
  const values = numbers(list);
  const runs = [];
  let run = null;
  for (const column of columns(Math.max(0, first), Math.min(values.length - 1, last))) {
    const found = extent(values, column.from, column.to);
    if (found === null) {
      run = null;
      continue;
    }
    if (run === null) runs.push((run = []));
    run.push({ x: x((column.from + column.to) / 2), frame: column.from, ...found });
  }
  return runs;
}

function* columns(first, last) {
  const window = visible();
  const from = Math.max(first, Math.floor(window.first) - 1);
  const to = Math.min(last, Math.ceil(window.last) + 1);
  const each = Math.max(1, Math.ceil(1 / pxPerFrame()));
  // Columns keep to multiples of their size: while one scrolls, the same frames stay together.
  for (let at = from - (from % each); at <= to; at += each) {
    yield { from: Math.max(at, from), to: Math.min(to, at + each - 1) };
  }
}

/** A run as a line: path data through its extremes, `y` turning a value into a pixel. */
export function line(run, y) {
  const points = run.map(({ x: at, low, high }) => {
    const where = at.toFixed(1);
    return low === high
      ? `${where} ${y(low).toFixed(1)}`
      : `${where} ${y(high).toFixed(1)}L${where} ${y(low).toFixed(1)}`;
  });
  return `M${points.join('L')}`;
}
