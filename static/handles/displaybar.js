// How the body is drawn and by what tools it is posed, as bars over the large view.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { iconOf, isOn, keyOf, labelOf, perform } from '../actions/actions.js';
import { clamp } from '../controls/arithmetic.js';
import { icon } from '../controls/icons.js';
import { menuButton, menuHolder } from '../controls/menu.js';
import { send } from '../store/link.js';
import { server, ui, watch } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { isSurface } from '../store/clip.js';
import { view as viewNamed } from '../views/views.js';
import { orbitEntries } from './viewmenu.js';
import { largeView } from './scale.js';

const TOOLS = /** @type {const} */ (['select', 'rotate', 'move', 'ends', 'size']);
const PAN_KEY = 'Space'; // while it is down, whatever the tool

export function toolbar() {
  return html`<div class="glass stack" id="tools" role="toolbar" aria-orientation="vertical" aria-label="Tools"
    @keydown=${walk}>
    ${TOOLS.map((id) => toolButton(id, keyOf(id)))}
    <hr />
    ${toolButton('pan', PAN_KEY)}
  </div>`;
}

/** @param {import('../actions/actions.js').ActionId} id */
function toolButton(id, key) {
  const letter = key.length === 1 ? html`<span class="k">${key}</span>` : nothing;
  return html`<button class="ib" data-tool=${id} aria-label=${labelOf(id)} aria-pressed=${isOn(id)}
    @click=${() => perform(id)}>${icon(iconOf(id))}${letter}${tipOf(id, key)}</button>`;
}

/** The words and the key of a button on a bar, shown beside it. */
export const tipOf = (id, key) => html`<span class="tip" aria-hidden="true">${labelOf(id)} <kbd>${key}</kbd></span>`;

/** Up and down walk along the bar, as in every toolbar. */
function walk(event) {
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (!step) return;
  const buttons = [...event.currentTarget.querySelectorAll('button')];
  const at = buttons.indexOf(document.activeElement);
  buttons[(at + step + buttons.length) % buttons.length].focus();
  event.preventDefault();
  event.stopPropagation();
}

const LEARNT = 'keypose.orbited';

export function freebar() {
  const view = viewNamed('free');
  const { camera } = view.habits;
  return html`<div class="glass row" id="mdisp" role="group" aria-label="Display">
    ${toggle('ghosts')}${toggle('trail')}
    <button class="ib s" data-toggle="film" aria-label="Film camera" aria-pressed=${camera}
      @click=${() => view.choose('camera', !camera)}>${icon('camc')}<span class="tip"
        aria-hidden="true">Film camera</span></button>
    <span class="vsep"></span>
    ${menuHolder(
      'orbit',
      () =>
        menuButton('orbit', { kind: 'btn ghost sm', title: 'How the view turns', face: html`Orbit${icon('chev')}` }),
      () => orbitEntries(view),
      'right',
    )}
    <button class="btn ghost sm" title="Reset the view"
      @click=${() => perform('fitView')}>Reset<kbd>${keyOf('fitView')}</kbd></button>
  </div>`;
}

/** How to turn the view, until somebody did for the first time. */
export function orbitHint() {
  if (inBrowser.read(LEARNT)) return nothing;
  return html`<div class="glass row low" id="morbit" role="status">${icon('rot')}<span>Right-drag to orbit
    <span class="mut">· right-click a part for its menu</span></span></div>`;
}

export function mountOrbitHint() {
  watch(['u:orbited'], () => ui.orbited && inBrowser.write(LEARNT, 'yes'));
}

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
  return html`<div class="glass row" id="mdisp" role="group" aria-label="Display">
    ${MODES.map(modeButton)}
    ${quad ? nothing : [slider(), html`<span class="num mut wide percent">${percent()} %</span>`]}
    <span class="vsep"></span>
    ${toggle('ghosts')}${toggle('trail')}${
      server.body?.is_persons && !isSurface()
        ? [toggle('rings'), largeView() === 'main' ? toggle('personMask') : nothing]
        : nothing
    }
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

export function tintbar() {
  if (!server.surface) return nothing;
  return html`<div class="glass stack" id="mtint" role="group" aria-label="Colours of the surface">
      <div class="seg">${server.surface.tints.map(choice)}</div>
      ${legend()}
    </div>
    ${problem()}`;
}

function choice({ id, label, title, off }) {
  return html`<button
    class=${off ? 'off' : ''}
    data-tint=${id}
    aria-pressed=${server.view.tint === id}
    aria-disabled=${off ? 'true' : nothing}
    title=${off || title}
    @click=${() => off || send({ do: 'display', tint: id })}
  >
    ${label}
  </button>`;
}

function legend() {
  const chosen = server.surface.tints.find(({ id }) => id === server.view.tint);
  if (!chosen?.high) return nothing;
  const stops = server.surface.ramp.join(',');
  return html`<div class="ramp" role="img" aria-label=${`From ${chosen.low} to ${chosen.high}`}>
    <span>${chosen.low}</span>
    <i style="background:linear-gradient(90deg,${stops})"></i>
    <span>${chosen.high}</span>
  </div>`;
}

function problem() {
  if (!server.surface.problem) return nothing;
  return html`<div class="glass" id="mproblem"
    role="status">${icon('warn')}<span>${server.surface.problem}</span></div>`;
}
