// What is shown of a film just opened, and a hint that the interval of the playhead can be shown alone.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { isZoomed, showAll, showFrames } from '../actions/window.js';
import { lastFrame } from '../store/clip.js';
import { keyOf, perform } from '../actions/actions.js';
import { keyFrames } from '../actions/playhead.js';

const AIR_OPENED = 0.1;
const LITTLE = 0.25; // of the film: the keyframes stand too close together to be worked with

/** Whether the keyframes take up little of a long film. */
function keyframesCoverLittle() {
  const keys = keyFrames();
  return keys.length > 1 && keys.at(-1) - keys[0] < LITTLE * lastFrame();
}

/** A film just opened is shown whole, or where its keyframes are. */
export function showOpened() {
  if (!keyframesCoverLittle()) return showAll();
  const [first, last] = [keyFrames()[0], keyFrames().at(-1)];
  const air = (last - first) * AIR_OPENED;
  return showFrames(first - air, last + air);
}

const HINT = 'keypose.zoom-hint';
const STAYS_MS = 30000;

/** null: not yet due; "shown"; "over": it was read, or zooming is known already. */
ui.zoomHint = inBrowser.read(HINT) === 'told' ? 'over' : null;

/**
 * Called with every drawing: whether it is time, or over. Shown once: a few keyframes in a long film
 * stand close together until the timeline is fitted to them.
 */
export function noticeZoom() {
  if (ui.zoomHint === 'over' || !server.file) return;
  if (ui.zoomHint === 'shown' && isZoomed()) return over();
  if (ui.zoomHint !== null || isZoomed() || !keyframesCoverLittle()) return;
  setUi('zoomHint', 'shown');
  setTimeout(over, STAYS_MS);
}

export function drawZoomHint() {
  if (ui.zoomHint !== 'shown') return nothing;
  return html`<button class="btn ghost sm zoomhint" @click=${() => perform('zoomToInterval')}>
    <kbd>${keyOf('zoomToInterval')}</kbd> zooms to the interval
  </button>`;
}

function over() {
  setUi('zoomHint', 'over');
  inBrowser.write(HINT, 'told');
}
