// Told once: a few keyframes in a long film stand close together until the timeline is fitted to them.

import { html, nothing } from '../../vendor/lit-html/lit-html.js';
import { S, U, put } from '../../store/state.js';
import { isZoomed } from '../draw/scale.js';
import { isKeyedLittle, zoomToInterval } from './zoom.js';

const KEPT = 'keypose.zoom-hint';
const STAYS_MS = 30000;

/** null: not yet due; "shown"; "over": it was read, or zooming is known already. */
U.zoomHint = isTold() ? 'over' : null;

/** Called with every drawing: whether it is time, or over. */
export function noticeZoom() {
  if (U.zoomHint === 'over' || !S.file) return;
  if (U.zoomHint === 'shown' && isZoomed()) return over();
  if (U.zoomHint !== null || isZoomed() || !isKeyedLittle()) return;
  put('zoomHint', 'shown');
  setTimeout(over, STAYS_MS);
}

export function drawZoomHint() {
  if (U.zoomHint !== 'shown') return nothing;
  return html`<button class="btn ghost sm zoomhint" @click=${zoomToInterval}>
    <kbd>Z</kbd> fits the interval
  </button>`;
}

function over() {
  put('zoomHint', 'over');
  try {
    localStorage.setItem(KEPT, 'told');
  } catch {
    // Then it is told once more next time.
  }
}

function isTold() {
  try {
    return localStorage.getItem(KEPT) === 'told';
  } catch {
    return false;
  }
}
