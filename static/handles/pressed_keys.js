// Which keys are down, at any moment of a drag.

const down = new Set();
const watchers = new Set();
let shift = false;
let control = false;
let alt = false;

/** Listen to the whole page. */
export function watchKeys() {
  // Capture on the window: whatever has the focus, and before any room acts on the key.
  addEventListener('keydown', (event) => note(event, true), true);
  addEventListener('keyup', (event) => note(event, false), true);
  addEventListener('blur', forget);
}

/** Call fn after a key went down or up. */
export function onKeys(fn) {
  watchers.add(fn);
}

/** The key's letter, whatever the shift state or the alphabet of the keyboard. */
export function letterOf(event) {
  const key = event.key.toLowerCase();
  if (/^[a-z]$/.test(key)) return key;
  return event.code.startsWith('Key') ? event.code.slice(3).toLowerCase() : key;
}

/** Whether a key is down: a letter, or " ". */
export const isKeyDown = (key) => down.has(key);

/** Shift as of the newest key or pointer event. */
export const isFine = () => shift;

/** Pointer events know the modifiers too, also those pressed outside the page. */
export function noteModifiers(event) {
  shift = event.shiftKey;
  control = event.ctrlKey || event.metaKey;
  alt = event.altKey;
}

/** What the keys that are down ask of a drag. */
export function modifiers() {
  const axis = ['x', 'y', 'z'].find((letter) => down.has(letter)) ?? null;
  return { snap: control, free: down.has('u'), axis, depth: down.has('d'), carry: alt };
}

function note(event, isDown) {
  noteModifiers(event);
  const key = letterOf(event);
  if (isDown) down.add(key);
  else down.delete(key);
  for (const fn of watchers) fn(event);
}

function forget() {
  down.clear();
  shift = control = alt = false;
}
