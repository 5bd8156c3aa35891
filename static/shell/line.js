// How the line to the server stands, for those who show it: ui.line is null while it is up or only
// just down, "lost", "long" when it may not come back by itself, "ended" when another Keypose answers.

import { fetchOwn } from '../store/key.js';
import { ui, setUi, watch } from '../store/state.js';

const LOST_MS = 2000;
const LONG_MS = 8000;
const LOOK_MS = 3000;

let downSince = 0;
let lookedAt = 0;
ui.line = null;

export function mountLine() {
  watch(['u:connected', 'u:line'], () => {
    document.documentElement.classList.toggle('no-line', ui.line !== null);
    tick();
  });
  setInterval(tick, 500);
}

function tick() {
  if (ui.connected) {
    downSince = 0;
    setUi('line', null);
    return;
  }
  downSince ||= performance.now();
  const down = performance.now() - downSince;
  if (down > LOST_MS && ui.line !== 'ended') setUi('line', down > LONG_MS ? 'long' : 'lost');
  if (down > LOST_MS) look();
}

/** Whether somebody else answers at this address: this page's key does not fit there any more. */
async function look() {
  if (performance.now() - lookedAt < LOOK_MS) return;
  lookedAt = performance.now();
  try {
    const { status } = await fetchOwn('/static/logo.svg', { cache: 'no-store' });
    if (ui.connected) return;
    if (status === 403) setUi('line', 'ended');
  } catch {
    // Nobody answers.
  }
}
