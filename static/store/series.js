// Series of one value a frame: the server sends what is known alone, so that an hour of film of which
// a minute is tracked is a minute's values; the page has a list with nulls.

/** Of every run of known values its first frame, then the values. @typedef {number[][]} Runs */

/** Sections as the page has them. */
export function unpacked(sections) {
  const read = Object.entries(READERS).filter(([name]) => sections[name]);
  return { ...sections, ...Object.fromEntries(read.map(([name, reader]) => [name, reader(sections[name])])) };
}

/** @param {Runs} runs @returns {import('./shapes.js').Series} */
export function listOf(runs) {
  const [start, ...values] = runs.at(-1) ?? [0];
  const list = new Array(start + values.length).fill(null);
  for (const [first, ...known] of runs) known.forEach((value, i) => (list[first + i] = value));
  return list;
}

/** Those of these names in an object, by default all. */
const listsIn = (object, names = Object.keys(object)) => ({
  ...object,
  ...Object.fromEntries(names.map((name) => [name, listOf(object[name])])),
});

const READERS = {
  need: listOf,
  lanes: (lanes) => listsIn(lanes),
  curve: (curve) => listsIn(curve, ['x', 'y', 'z', 'error']),
  joint_angle: (shown) => ({
    ...shown,
    sides: shown.sides.map((side) => listsIn(side, side.errors ? ['values', 'errors'] : ['values'])),
  }),
};
