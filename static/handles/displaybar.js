// How the body is drawn: wire, solid or both, how opaque; ghosts and trail.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { send } from '../store/link.js';
import { icon } from '../controls/icons.js';

const MODES = [
  { mode: 'wire', label: 'Wire' },
  { mode: 'solid', label: 'Solid' },
  { mode: 'both', label: 'Both' },
];
const STEP = 0.05;
const PAUSE_MS = 33;

// What the slider was last dragged to: the server's echo comes later and must not pull it back.
let sliding = null;
let told = 0;
let redraw = () => {};

/** What draws the bars anew. */
export function onSlide(fn) {
  redraw = fn;
}

export function displaybar() {
  const quad = ui.layout === 'quad';
  return html`<div class="glass" id="mdisp" role="group" aria-label="Display">
    ${MODES.map(modeButton)}
    ${quad ? nothing : [slider(), html`<span class="num mut wide percent">${percent()} %</span>`]}
    <span class="vsep"></span>
    ${toggle('ghosts', 'ghost', 'Ghosts of the neighbouring keyframes', 'O')}
    ${toggle('trail', 'trail', 'Motion trail', 'M')}
  </div>`;
}

const opacity = () => sliding ?? server.view.opacity;
const percent = () => Math.round(100 * opacity());

function modeButton({ mode, label }) {
  return html`<button class="ib s" data-mode=${mode} aria-label=${label} aria-pressed=${server.view.mode === mode}
    @click=${() => send({ do: 'display', mode })}>
    ${icon(mode)}<span class="tip" aria-hidden="true">${label} <kbd>W</kbd></span>
  </button>`;
}

function toggle(name, sign, label, key) {
  const on = Boolean(server.view[name]);
  return html`<button class="ib s" data-toggle=${name} aria-label=${label} aria-pressed=${on}
    @click=${() => send({ do: 'display', [name]: !on })}>
    ${icon(sign)}<span class="tip" aria-hidden="true">${label} <kbd>${key}</kbd></span>
  </button>`;
}

function slider() {
  const value = percent();
  return html`<div class="rng opa" role="slider" tabindex="0" aria-label="Opacity" aria-valuemin="0"
    aria-valuemax="100" aria-valuenow=${value} @pointerdown=${grab} @pointermove=${slide}
    @pointerup=${drop} @pointercancel=${drop} @keydown=${nudge} @wheel=${roll}>
    <span class="fill" style="left:0;width:${value}%"></span><span class="th" style="left:${value}%"></span>
  </div>`;
}

function grab(event) {
  event.preventDefault();
  event.currentTarget.setPointerCapture(event.pointerId);
  sliding = opacity();
  slide(event);
}

function slide(event) {
  if (sliding === null) return;
  const box = event.currentTarget.getBoundingClientRect();
  sliding = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
  if (performance.now() - told > PAUSE_MS) tell(sliding);
}

function drop() {
  if (sliding === null) return;
  tell(sliding);
  sliding = null;
}

function nudge(event) {
  const step = { ArrowRight: STEP, ArrowUp: STEP, ArrowLeft: -STEP, ArrowDown: -STEP }[event.key];
  if (!step) return;
  event.preventDefault();
  event.stopPropagation();
  tell(opacity() + step);
}

function roll(event) {
  event.preventDefault();
  tell(opacity() - Math.sign(event.deltaY) * STEP);
}

function tell(value) {
  told = performance.now();
  const kept = Math.min(1, Math.max(0, Math.round(value * 100) / 100));
  // Shown at once: the answer is only a confirmation.
  server.view = { ...server.view, opacity: kept };
  send({ do: 'display', opacity: kept });
  redraw();
}
