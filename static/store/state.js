// What the page knows. `server` holds the newest of the server's sections, `ui` this tab's own values.
// A room watches the names it draws and is called once per animation frame after any of them
// changed. Names of `ui` carry the prefix "u:".

/** @typedef {import('./shapes.js').Sections} Sections */
/** @typedef {import('./shapes.js').Ui} Ui */

/** @type {Partial<Sections>} */
export const server = {};

/** @type {Ui} */
export const ui = {
  tool: 'select',
  layout: 'main',
  tab: 'part',
  chart: 'angle',
  lanes: true,
  hover: null,
  dragging: false,
  playing: false,
  speed: 1,
  shuttle: 1,
  loop: false,
  span: { first: null, last: null },
  connected: false,
};

const watchers = new Set();
const afterwards = new Set();
const changed = new Set();
let asked = false;

/**
 * Call fn once per animation frame after any of the names changed, and once at the start.
 * @param {import('./shapes.js').Watched[]} names
 * @param {() => void} fn
 */
export function watch(names, fn) {
  const watcher = { names: new Set(names), fn };
  watchers.add(watcher);
  mark(names[0]);
  return () => watchers.delete(watcher);
}

/** Call fn after every redraw, when everybody has drawn. @param {() => void} fn */
export const onRedraw = (fn) => void afterwards.add(fn);

/**
 * Set one of this tab's own values.
 * @template {keyof Ui} K
 * @param {K} name
 * @param {Ui[K]} value
 */
export function setUi(name, value) {
  if (ui[name] === value) return;
  ui[name] = value;
  mark('u:' + name);
}

/**
 * Sections that add, remove or move controls without the person's doing. While a control is pressed
 * they wait, so that it stays under the pointer; what a gesture itself changes never waits.
 * @type {Set<keyof Sections>}
 */
const UNASKED = new Set([
  'job',
  'segments',
  'errors',
  'space',
  'suggest',
  'proposed_pins',
  'fit',
  'sizes_preview',
  'draft',
  'people',
  'saved',
  'undo',
  'guide',
  'damage',
  'cues',
  'networks',
  'keypoints',
  'tabs',
]);

/** @type {Partial<Sections> | null} */
let waiting = null;

/** Take over sections from the server. */
export function applySections(sections) {
  // With another file everything is another.
  if (sections.file !== undefined && sections.file?.path !== server.file?.path) release();
  for (const [name, value] of Object.entries(sections)) {
    if (waiting !== null && UNASKED.has(/** @type {keyof Sections} */ (name))) {
      waiting[name] = value;
      continue;
    }
    server[name] = value;
    mark(name);
  }
}

/** A control is pressed: what would move it waits until `release`. */
export function hold() {
  waiting ??= {};
}

/** What has waited is taken over. */
export function release() {
  const sections = waiting ?? {};
  waiting = null;
  for (const [name, value] of Object.entries(sections)) {
    server[name] = value;
    mark(name);
  }
}

function mark(name) {
  changed.add(name);
  if (asked) return;
  asked = true;
  // A tab in the background gets no animation frames, but is right when one comes back to it.
  if (document.hidden) setTimeout(redraw);
  else requestAnimationFrame(redraw);
}

document.addEventListener('visibilitychange', () => asked && setTimeout(redraw));

function redraw() {
  if (!asked) return;
  asked = false;
  const names = [...changed];
  changed.clear();
  for (const watcher of watchers) {
    if (!names.some((name) => watcher.names.has(name))) continue;
    try {
      watcher.fn();
    } catch (error) {
      // One room that stumbles must not stop the others.
      reportError(error);
    }
  }
  for (const fn of afterwards) fn();
}
