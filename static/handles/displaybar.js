// How the body is drawn: wire, solid or both, how opaque; ghosts and trail.

import { clamp } from '../controls/arithmetic.js';
import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { send } from '../store/link.js';
import { isSurface } from '../store/subject.js';
import { iconOf, isOn, keyOf, labelOf, perform } from '../actions/actions.js';
import { icon } from '../controls/icons.js';
import { freebar } from './freebar.js';
import { largeView } from './scale.js';
import { tipOf } from './toolbar.js';

const MODES = /** @type {const} */ (['wire', 'solid', 'both']);
const STEP = 0.05;
const PAUSE_MS = 33;

// What the slider was last dragged to: the server's echo comes later and must not pull it back.
let sliding = null;
let sentAt = 0;
let redraw = () => {};

/** What draws the bars anew. */
export function onSlide(fn) {
  redraw = fn;
}

export function displaybar() {
  if (ui.layout === 'free') return freebar();
  const quad = ui.layout === 'quad';
  return html`<div class="glass" id="mdisp" role="group" aria-label="Display">
    ${MODES.map(modeButton)}
    ${quad ? nothing : [slider(), html`<span class="num mut wide percent">${percent()} %</span>`]}
    <span class="vsep"></span>
    ${toggle('ghosts')}${toggle('trail')}${server.body?.is_persons && !isSurface() ? toggle('rings') : nothing}
    ${largeView() === 'main' ? toggle('floor') : nothing}
  </div>`;
}

const opacity = () => sliding ?? server.view.opacity;
const percent = () => Math.round(100 * opacity());

function modeButton(id) {
  return html`<button class="ib s" data-mode=${id} aria-label=${labelOf(id)} aria-pressed=${isOn(id)}
    @click=${() => perform(id)}>${face(id, keyOf('nextMode'))}</button>`;
}

function toggle(id) {
  return html`<button class="ib s" data-toggle=${id} aria-label=${labelOf(id)} aria-pressed=${isOn(id)}
    @click=${() => perform(id)}>${face(id, keyOf(id))}</button>`;
}

const face = (id, key) => html`${icon(iconOf(id))}${tipOf(id, key)}`;

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
  sliding = clamp((event.clientX - box.left) / box.width, 0, 1);
  if (performance.now() - sentAt > PAUSE_MS) setOpacity(sliding);
}

function drop() {
  if (sliding === null) return;
  setOpacity(sliding);
  sliding = null;
}

function nudge(event) {
  const step = { ArrowRight: STEP, ArrowUp: STEP, ArrowLeft: -STEP, ArrowDown: -STEP }[event.key];
  if (!step) return;
  event.preventDefault();
  event.stopPropagation();
  setOpacity(opacity() + step);
}

function roll(event) {
  event.preventDefault();
  setOpacity(opacity() - Math.sign(event.deltaY) * STEP);
}

function setOpacity(value) {
  sentAt = performance.now();
  const kept = clamp(Math.round(value * 100) / 100, 0, 1);
  // Shown at once: the answer is only a confirmation.
  server.view = { ...server.view, opacity: kept };
  send({ do: 'display', opacity: kept });
  redraw();
}
