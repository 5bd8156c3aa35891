// What the page's modules need of a browser before they can be imported, and animation frames that
// come when a test says so. To be imported first.

import { webcrypto } from 'node:crypto';

let asked = new Map();
let count = 0;

globalThis.requestAnimationFrame = (fn) => {
  asked.set(++count, fn);
  return count;
};
globalThis.cancelAnimationFrame = (id) => void asked.delete(id);
globalThis.crypto ??= webcrypto;
globalThis.HTMLElement ??= /** @type {any} */ (class {});
globalThis.customElements ??= /** @type {any} */ ({ define() {} });
globalThis.location = { origin: 'http://127.0.0.1' };
globalThis.document = {
  hidden: false,
  addEventListener() {},
  createComment: () => ({}),
  createTreeWalker: () => ({}),
};

/** One animation frame: what was asked for until now happens. */
export function animationFrame() {
  const now = [...asked.values()];
  asked = new Map();
  for (const fn of now) fn(0);
}
