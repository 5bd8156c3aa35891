// The bar of the free view: ghosts, feet's ways, the film's camera, how one orbits; and its hint.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { iconOf, isOn, keyOf, labelOf, perform } from '../actions/actions.js';
import { icon } from '../controls/icons.js';
import { menuButton, menuHolder } from '../controls/menu.js';
import { inBrowser } from '../store/storage.js';
import { ui, watch } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { orbitEntries } from './partmenu.js';
import { tipOf } from './toolbar.js';

const LEARNT = 'keypose.orbited';

export function freebar() {
  const view = viewNamed('free');
  const { camera } = view.habits;
  return html`<div class="glass" id="mdisp" role="group" aria-label="Display">
    ${toggle('ghosts')}${toggle('trail')}
    <button class="ib s" data-toggle="film" aria-label="Film camera" aria-pressed=${camera}
      @click=${() => view.choose('camera', !camera)}>${icon('camc')}<span class="tip" aria-hidden="true">Film camera</span></button>
    <span class="vsep"></span>
    ${menuHolder('orbit', () => menuButton('orbit', { kind: 'btn ghost sm', title: 'How the view turns', face: html`Orbit${icon('chev')}` }), () => orbitEntries(view), 'right')}
    <button class="btn ghost sm" title="Reset the view" @click=${() => perform('fitView')}>Reset<kbd>${keyOf('fitView')}</kbd></button>
  </div>`;
}

function toggle(id) {
  return html`<button class="ib s" data-toggle=${id} aria-label=${labelOf(id)} aria-pressed=${isOn(id)}
    @click=${() => perform(id)}>${icon(iconOf(id))}${tipOf(id, keyOf(id))}</button>`;
}

/** How to turn the view, until somebody did for the first time. */
export function orbitHint() {
  if (inBrowser.read(LEARNT)) return nothing;
  return html`<div class="glass low" id="morbit" role="status">${icon('rot')}<span>Right-drag to orbit
    <span class="mut">· right-click a part for its menu</span></span></div>`;
}

export function mountOrbitHint() {
  watch(['u:orbited'], () => ui.orbited && inBrowser.write(LEARNT, 'yes'));
}
