// All lanes of the timeline, or the weakest part's alone.

import { setUi, ui } from '../store/state.js';
import { inBrowser } from '../store/storage.js';

const LANES = 'keypose.timeline.lanes';
const SMALL = '(max-width: 1359px), (max-height: 819px)';

/** Lanes are folded in small windows, unless all were asked for. */
export function mountFold() {
  matchMedia(SMALL).addEventListener('change', apply);
  apply();
}

export function areFolded() {
  return !ui.lanes;
}

/** Fold the lanes or open them; what was asked for is kept in this browser. */
export function foldLanes() {
  inBrowser.write(LANES, ui.lanes ? 'folded' : 'open');
  apply();
}

function apply() {
  const asked = inBrowser.read(LANES);
  const open = asked === null ? !matchMedia(SMALL).matches : asked === 'open';
  // The sheet gives opened lanes their height in windows that would not have it.
  document.documentElement.dataset.lanes = open ? 'open' : 'folded';
  setUi('lanes', open);
}
