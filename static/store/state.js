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

/** Take over sections from the server. */
export function applySections(sections) {
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
}
