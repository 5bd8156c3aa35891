// The connections of viser's pages, made again after a loss. Left alone, each page would try once a
// second and break off the attempt before. But a browser puts attempts off by seconds once many have
// failed, so that none would ever succeed. Hence the page lets them try: seldom, and only while it
// is connected itself.

import { ui, watch } from '../store/state.js';

/** Longer than an attempt can take: viser ends it after five seconds. */
const AGAIN_MS = 7000;

/** Reconnect viser's page in this window; returns how to stop. */
export function reconnectSeldom(window) {
  let tried = performance.now(); // a new page tries by itself
  let may = false;
  // viser asks for the focus only when it is not connected.
  window.document.hasFocus = () => {
    if (may) tried = performance.now();
    return may;
  };
  const reconnect = () => {
    if (!ui.connected || performance.now() - tried < AGAIN_MS) return;
    may = true;
    window.dispatchEvent(new Event('focus')); // tries now, and would again each second
    may = false;
    window.dispatchEvent(new Event('blur')); // but does not
  };
  const unwatch = watch(['u:connected'], reconnect);
  const timer = setInterval(reconnect, AGAIN_MS);
  return () => {
    unwatch();
    clearInterval(timer);
  };
}
