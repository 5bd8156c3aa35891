// The lines of viser's pages, had again after a loss. Left alone, each page would try once a second
// and break off the attempt before. But a browser puts attempts off by seconds once many have
// failed, so that none would ever succeed. Hence the page lets them try: seldom, and only while its
// own line is there.

import { ui, watch } from '../store/state.js';

/** Longer than an attempt can take: viser ends it after five seconds. */
const AGAIN_MS = 7000;

/** See to the line of viser's page in this window; returns how to stop. */
export function keepLine(window) {
  let tried = performance.now(); // a new page tries by itself
  let may = false;
  // viser asks for the focus when it has no line, and then only.
  window.document.hasFocus = () => {
    if (may) tried = performance.now();
    return may;
  };
  const revive = () => {
    if (!ui.connected || performance.now() - tried < AGAIN_MS) return;
    may = true;
    window.dispatchEvent(new Event('focus')); // tries now, and would again each second
    may = false;
    window.dispatchEvent(new Event('blur')); // but does not
  };
  const unwatch = watch(['u:connected'], revive);
  const timer = setInterval(revive, AGAIN_MS);
  return () => {
    unwatch();
    clearInterval(timer);
  };
}
