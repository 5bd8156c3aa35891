// Told once: a few keyframes in a long film stand close together until the timeline is fitted to them.

import { html, nothing } from '../../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../../store/state.js';
import { inBrowser } from '../../store/storage.js';
import { isZoomed } from '../draw/scale.js';
import { isKeyedLittle, zoomToInterval } from './zoom.js';

const KEPT = 'keypose.zoom-hint';
const STAYS_MS = 30000;

/** null: not yet due; "shown"; "over": it was read, or zooming is known already. */
ui.zoomHint = inBrowser.read(KEPT) === 'told' ? 'over' : null;

/** Called with every drawing: whether it is time, or over. */
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
  inBrowser.write(KEPT, 'told');
}
