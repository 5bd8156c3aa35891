// One number per frame, NaN where there is none: what comes as a list with nulls is turned once
// into an array of numbers, over which even 200,000 frames are gone through within a frame.

const EMPTY = new Float32Array(0);
const known = new WeakMap();

/** The numbers of a list, or of nothing; the same list gives the same array again. */
export function numbers(list) {
  if (!list) return EMPTY;
  if (list instanceof Float32Array) return list;
  if (!known.has(list)) known.set(list, Float32Array.from(list, (value) => value ?? NaN));
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
