// Handles that lie over each other, such as a hand behind the hip: which of them is meant, in which
// order a further press at the same place, or Tab, goes through them, and the one that was chosen so.

/** As shares of a handle's reach: nearer to each other than this the pointer cannot tell them apart. */
const AS_NEAR = 0.35;

/** @typedef {{ target: any, miss: number }} Found */
/** @typedef {{ view: string, key: string, order: string[] }} Chosen */

/**
 * Those found, the likeliest first: the nearest, or as near as it the selected part's.
 * @param {Found[]} found  The nearest first.
 * @param {string | null} selected
 */
export function likeliestFirst(found, selected) {
  const targets = found.map(({ target }) => target);
  const own = found.find(({ target, miss }) => target.part === selected && miss - found[0].miss < AS_NEAR);
  return own ? [own.target, ...targets.filter((target) => target !== own.target)] : targets;
}

/**
 * In the order they had when one of them was chosen, as long as they are the same.
 * @param {any[]} stack
 * @param {Chosen | null} chosen
 */
export function asBefore(stack, chosen) {
  if (chosen?.order.length !== stack.length) return stack;
  const before = chosen.order.map((key) => stack.find((target) => target.key === key));
  return before.every(Boolean) ? before : stack;
}

/**
 * The chosen one, as long as it lies there, else the likeliest.
 * @param {any[]} stack
 * @param {Chosen | null} chosen
 */
export const meant = (stack, chosen) => stack.find(({ key }) => key === chosen?.key) ?? stack[0] ?? null;

/**
 * The one after this.
 * @param {any[]} stack
 * @param {any} target
 */
export const after = (stack, target) => stack[(stack.findIndex(({ key }) => key === target.key) + 1) % stack.length];

/** "2 of 3", or nothing where one lies alone. @param {any[]} stack */
export function whichOf(stack, target) {
  const at = stack.findIndex(({ key }) => key === target.key);
  return at < 0 || stack.length < 2 ? '' : `${at + 1} of ${stack.length}`;
}
