// What of this tab's own survives a reload: the tool in hand and the inspector's tab.

import { ui, watch } from './state.js';

const KEPT = { tool: ['select', 'rotate', 'move', 'ends', 'size'], tab: ['part', 'body', 'camera', 'track'] };

export function mount() {
  for (const [name, known] of Object.entries(KEPT)) {
    const value = read(name);
    // A drawing that was begun is gone, so its tool is put down.
    if (known.includes(value)) ui[name] = value;
    watch([/** @type {import('./shapes.js').Watched} */ ('u:' + name)], () => write(name, ui[name]));
  }
}

const keyOf = (name) => `keypose.${name}`;

function read(name) {
  try {
    return sessionStorage.getItem(keyOf(name));
  } catch {
    return null; // a browser that keeps nothing
  }
}

function write(name, value) {
  try {
    sessionStorage.setItem(keyOf(name), value);
  } catch {
    // Then a reload begins with the usual ones.
  }
}
