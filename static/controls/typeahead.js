// Letters typed in a menu lead to the entry that begins with them.

const PAUSE_MS = 700;

/** What was typed until now, and when last. */
let typed = '';
let last = -Infinity;

/** Another menu has opened: what was typed in the one before does not count. */
export function beginTyping() {
  last = -Infinity;
}

/**
 * The entry that is meant by one more letter, or -1.
 * @param {string[]} labels
 * @param {number} at  The entry that has the focus, or -1.
 * @param {string} letter
 * @param {number} now  Milliseconds.
 */
export function typedTo(labels, at, letter, now) {
  const goesOn = now - last < PAUSE_MS;
  last = now;
  const whole = (goesOn ? typed : '') + letter.toLowerCase();
  const to = meant(labels, at, whole);
  // What no entry begins with is a new word.
  typed = to < 0 ? letter.toLowerCase() : whole;
  return to < 0 && goesOn ? meant(labels, at, typed) : to;
}

function meant(labels, at, wanted) {
  // The same letter again and again goes through all that begin with it.
  const isOne = [...wanted].every((each) => each === wanted[0]);
  const begins = isOne ? wanted[0] : wanted;
  const start = isOne ? at + 1 : Math.max(at, 0);
  const order = labels.map((_, i) => (start + i) % labels.length);
  return order.find((i) => labels[i].toLowerCase().startsWith(begins)) ?? -1;
}
