// What is shown: the interval of the playhead or everything, once to see it and once more to go back;
// all lanes, or the weakest part's alone.

import { html, nothing } from '../../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../../store/state.js';
import { inBrowser } from '../../store/storage.js';
import { isZoomed, lastFrame, showAll, showFrames, shown } from '../draw/scale.js';
import { around, frame, keyFrames } from './head.js';

const AIR = 0.06;
const AIR_OPENED = 0.1;
const LITTLE = 0.25; // of the film: the keyframes stand too close together to be worked with

/** Whether the keyframes take up little of a long film. */
function isKeyedLittle() {
  const keys = keyFrames();
  return keys.length > 1 && keys.at(-1) - keys[0] < LITTLE * lastFrame();
}

/** A film just opened is shown whole, or where its keyframes are. */
export function showOpened() {
  if (!isKeyedLittle()) return showAll();
  const [first, last] = [keyFrames()[0], keyFrames().at(-1)];
  const air = (last - first) * AIR_OPENED;
  return showFrames(first - air, last + air);
}

/** Show these frames with a little air on both sides. */
export function zoomTo(first, last) {
  const air = (last - first) * AIR;
  showFrames(first - air, last + air);
}

/** Fit the interval of the playhead; when it is fitted already, show the whole clip. */
export function zoomToInterval() {
  const keys = keyFrames();
  const [first, last] = around(frame()) ?? [
    keys.findLast((key) => key <= frame()) ?? 0,
    keys.find((key) => key > frame()) ?? lastFrame(),
  ];
  if (last <= first) return showAll();
  const before = shown();
  const was = isZoomed();
  zoomTo(first, last);
  const now = shown();
  if (was && Math.abs(now.first - before.first) + Math.abs(now.last - before.last) < 0.01) showAll();
}

const HINT = 'keypose.zoom-hint';
const STAYS_MS = 30000;

/** null: not yet due; "shown"; "over": it was read, or zooming is known already. */
ui.zoomHint = inBrowser.read(HINT) === 'told' ? 'over' : null;

/**
 * Called with every drawing: whether it is time, or over. Told once: a few keyframes in a long film
 * stand close together until the timeline is fitted to them.
 */
export function noticeZoom() {
  if (ui.zoomHint === 'over' || !server.file) return;
  if (ui.zoomHint === 'shown' && isZoomed()) return over();
  if (ui.zoomHint !== null || isZoomed() || !isKeyedLittle()) return;
  setUi('zoomHint', 'shown');
  setTimeout(over, STAYS_MS);
}

export function drawZoomHint() {
  if (ui.zoomHint !== 'shown') return nothing;
  return html`<button class="btn ghost sm zoomhint" @click=${zoomToInterval}>
    <kbd>Z</kbd> fits the interval
  </button>`;
}

function over() {
  setUi('zoomHint', 'over');
  inBrowser.write(HINT, 'told');
}

const LANES = 'keypose.timeline.lanes';
const small = matchMedia('(max-width: 1359px), (max-height: 819px)');

/** Lanes are folded in small windows, unless all were asked for. */
export function mountFold() {
  small.addEventListener('change', apply);
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
  const open = asked === null ? !small.matches : asked === 'open';
  // The sheet gives opened lanes their height in windows that would not have it.
  document.documentElement.dataset.lanes = open ? 'open' : 'folded';
  setUi('lanes', open);
}
