// What of this tab's own survives a reload: the tool in hand and the inspector's tab.

import { ui, watch } from './state.js';
import { inTab } from './storage.js';

const KEPT = { tool: ['select', 'rotate', 'move', 'ends', 'size'], tab: ['part', 'body', 'camera', 'track'] };

export function mount() {
  for (const [name, known] of Object.entries(KEPT)) {
    const value = inTab.read(keyOf(name));
    // A drawing that was begun is gone, so its tool is put down.
    if (known.includes(value)) ui[name] = value;
    watch([/** @type {import('./shapes.js').Watched} */ ('u:' + name)], () => inTab.write(keyOf(name), ui[name]));
  }
}

const keyOf = (name) => `keypose.${name}`;
