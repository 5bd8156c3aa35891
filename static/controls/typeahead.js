// Letters typed in a menu lead to the entry that begins with them.

const PAUSE_MS = 700;

/** What was typed until now, and when last. */
let typed = '';
let last = -Infinity;

/**
 * The entry that is meant by one more letter, or -1.
 * @param {string[]} labels
 * @param {number} at  The entry that has the focus, or -1.
 * @param {string} letter
 * @param {number} now  Milliseconds.
 */
export function typedTo(labels, at, letter, now) {
  typed = now - last < PAUSE_MS ? typed + letter.toLowerCase() : letter.toLowerCase();
  last = now;
  // The same letter again and again goes through all that begin with it.
  const isOne = [...typed].every((each) => each === typed[0]);
  const wanted = isOne ? typed[0] : typed;
  const start = isOne ? at + 1 : Math.max(at, 0);
  const order = labels.map((_, i) => (start + i) % labels.length);
  return order.find((i) => labels[i].toLowerCase().startsWith(wanted)) ?? -1;
}
