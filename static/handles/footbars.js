// The feet of the large view: which frame, and how near.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { keyOf, perform, titleOf } from '../actions/actions.js';
import { smallWords } from '../actions/drafting.js';
import { icon } from '../controls/icons.js';
import { view as viewNamed } from '../views/views.js';
import { orbitHint } from './freebar.js';
import { largeView } from './scale.js';
import { sketchHint } from './sketch.js';

const ZOOM_STEP = 1.25;
const HINT_ICONS = { mask: 'loop', vertical: 'mid', horizon: 'floor', box: 'wand' };

export function footbars() {
  if (ui.layout === 'quad') return sketchLine();
  if (ui.layout === 'free') return [frameBox(), orbitHint()];
  return [frameBox(), zoomBox(), sketchLine()];
}

function frameBox() {
  const { frame } = server.view;
  return html`<div class="glass" id="mfoot">
    <span class="fr num">${frame}</span>
    <span class="num dim of">of ${server.file.frames - 1}<br />${clock(secondsAt(frame))}</span>
  </div>`;
}

const secondsAt = (frame) => server.file.times?.[frame] ?? frame / server.file.fps;

/** 0:00.83 */
function clock(seconds) {
  const minutes = Math.floor(seconds / 60);
  return `${minutes}:${(seconds - 60 * minutes).toFixed(2).padStart(5, '0')}`;
}

function zoomBox() {
  const view = viewNamed(largeView());
  const { width, height, scale } = view.window;
  const zoom = (factor) => view.zoomAt(width / 2, height / 2, factor);
  const film = view.name === 'main';
  return html`<div class="glass" id="mzoom">
    <button class="ib s" aria-label="Zoom out" title="Zoom out" @click=${() => zoom(1 / ZOOM_STEP)}>${icon('minus')}</button>
    <button class="btn ghost sm num z" title=${film ? 'One to one' : 'Pixels per metre'}
      @click=${() => film && zoom(1 / scale)}>${film ? `${Math.round(100 * scale)} %` : `${Math.round(scale)} px/m`}</button>
    <button class="ib s" aria-label="Zoom in" title="Zoom in" @click=${() => zoom(ZOOM_STEP)}>${icon('plus')}</button>
    <span class="vsep"></span>
    <button class="btn ghost sm" title=${titleOf('fitView')} data-key=${keyOf('fitView')} @click=${() => perform('fitView')}>Fit</button>
  </div>`;
}

/** What to do with the drawing tool in hand. */
function sketchLine() {
  const hint = sketchHint();
  if (!hint) return nothing;
  const isWarning = ui.tool === 'box' && smallWords() !== '';
  const name = isWarning ? 'warn' : HINT_ICONS[ui.tool];
  const place = ui.tool === 'box' ? 'low' : '';
  return html`<div class="glass ${place} ${isWarning ? 'warned' : ''}" id="mhint" role="status">${icon(name)}${hint}</div>`;
}
