// Degrees up, pixels down: the range a curve is drawn in, and the steps its scale is numbered in.

import { remembered } from './layers.js';
import { extent, numbers } from './series.js';

const STEPS = [1, 2, 5, 10, 15, 20, 30, 45, 60, 90, 180, 360];
const LEAST_SPAN = 20;
const TICKS_APART_PX = 15;
const MOST_TICKS = 6;
const MARGIN = 6;

/** The range of a series with some air: {low, high}; null without values. */
export const rangeOf = remembered((list) => {
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
