// How far off the parts of a segment are expected to be: the worst of them, each at its worst frame.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { partNamed, select } from '../store/parts.js';
import { goTo, stopPlaying } from '../actions/playhead.js';
import { clamp } from '../controls/arithmetic.js';
import { roughError } from '../controls/words.js';

/** A bar this long is full. */
const FULL_PX = 10;

/** The rows of a segment; nothing where nothing is known. */
export function expectedErrors({ first }) {
  const rows = (server.errors ?? []).filter((error) => error.first === first && partNamed(error.part));
  if (rows.length === 0) return nothing;
  return html`<div class="errors" role="group" aria-label="Expected error">
    <h3 aria-level="2">Expected error</h3>
    ${rows.map(row)}
  </div>`;
}

function row({ part: name, frame, px, cm }) {
  const { label, side } = partNamed(name);
  const share = clamp(px / FULL_PX, 0, 1);
  return html`<button
    type="button"
    class="error ${name === server.view.selected ? 'sel' : ''}"
    title=${`Largest at frame ${frame}. Select ${label.toLowerCase()} and go there`}
    @click=${() => visit(name, frame)}
  >
    <span class="cut">${label}</span>
    <span class="bar"><i style="width:${(100 * share).toFixed(0)}%;background:var(--${side})"></i></span>
    <span class="num">${roughError(px, cm)}</span>
  </button>`;
}

function visit(name, frame) {
  stopPlaying();
  select(name);
  goTo(frame);
}
