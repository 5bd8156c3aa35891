// Lanes folded into one, "Weakest part", or all of them: folded in small windows unless asked for.

import { ui, setUi } from '../../store/state.js';
import { inBrowser } from '../../store/storage.js';

const KEPT = 'keypose.timeline.lanes';
const small = matchMedia('(max-width: 1359px), (max-height: 819px)');

export function mountFold() {
  small.addEventListener('change', apply);
  apply();
}

export function areFolded() {
  return !ui.lanes;
}

/** Fold the lanes or open them; what was asked for is kept in this browser. */
export function foldLanes() {
  inBrowser.write(KEPT, ui.lanes ? 'folded' : 'open');
  apply();
}

function apply() {
  const asked = inBrowser.read(KEPT);
  const open = asked === null ? !small.matches : asked === 'open';
  // The sheet gives opened lanes their height in windows that would not have it.
  document.documentElement.dataset.lanes = open ? 'open' : 'folded';
  setUi('lanes', open);
}
