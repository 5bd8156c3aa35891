// How the line to the server stands, for those who show it: ui.line is null while it is up or only
// just down, "lost", "long" when it may not come back by itself, "ended" when somebody
// answers who does not know this browser.

import { lastReceived } from '../store/link.js';
import { ui, setUi, watch } from '../store/state.js';

const LOST_MS = 2000;
const LONG_MS = 8000;

let downSince = 0;
ui.line = null;

export function mountLine() {
  watch(['u:connected', 'u:line', 'u:turnedAway'], () => {
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
  downSince ||= lastReceived();
  const down = performance.now() - downSince;
  if (down <= LOST_MS) return;
  setUi('line', ui.turnedAway ? 'ended' : down > LONG_MS ? 'long' : 'lost');
}
