// What a browser keeps for this page: over visits, or for one tab over a reload. A browser that keeps
// nothing, or has no room left, has it at least as long as the page is.

import { ui, watch } from './state.js';

/** @param {() => Storage} place */
function storage(place) {
  const unkept = new Map();
  const attempt = (act) => {
    try {
      return act(place());
    } catch {
      return undefined; // keeping was forbidden, or there is no room
    }
  };
  return {
    /** What was kept under this name, or null. */
    read: (name) => unkept.get(name) ?? attempt((kept) => kept.getItem(name)) ?? null,
    write(name, value) {
      const isKept = attempt((kept) => {
        kept.setItem(name, String(value));
        return true;
      });
      if (isKept) unkept.delete(name);
      else unkept.set(name, String(value));
    },
    remove(name) {
      unkept.delete(name);
      attempt((kept) => kept.removeItem(name));
    },
  };
}

/** Over visits, for every tab of this page's origin. */
export const inBrowser = storage(() => localStorage);

/** Over a reload, for this tab alone. */
export const inTab = storage(() => sessionStorage);

const KEPT = { tool: ['select', 'rotate', 'move', 'ends', 'size'], tab: ['part', 'body', 'camera', 'track'] };

/** Restore the tool in hand and the inspector's tab after a reload, and keep them from now on. */
export function mountMemory() {
  for (const [name, known] of Object.entries(KEPT)) {
    const value = inTab.read(keyOf(name));
    // A drawing that was begun is lost, so its tool is put down.
    if (known.includes(value)) ui[name] = value;
    watch([/** @type {import('./shapes.js').Watched} */ ('u:' + name)], () => inTab.write(keyOf(name), ui[name]));
  }
}

const keyOf = (name) => `keypose.${name}`;
