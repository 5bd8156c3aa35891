// What a browser keeps for this page: over visits, or for one tab; and the key of its origin. A
// browser that keeps nothing, or has no room left, has it at least as long as the page is. Cookies go
// to every server on this host, whatever its port; what is stored for the origin stays here.

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

const NAME = 'keypose.key';

/** The newest: another tab may have been let in anew. */
function key() {
  return inBrowser.read(NAME) ?? ''; // without one this browser is not let in
}

/** Fetch from this page's own server. */
export function fetchOwn(path, options = {}) {
  return fetch(path, { ...options, headers: { ...options.headers, ...keyHeader() } });
}

/** Whether it has one: a browser whose stored data was cleared has not. */
export const hasKey = () => key() !== '';

export const keyHeader = () => ({ 'X-Keypose-Key': key() });

/** The subprotocols of the line of events: a page can give a socket no header. */
export const keyProtocols = () => ['keypose', `keypose-key.${key()}`];
