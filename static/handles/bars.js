// The glass bars over the large view. They move with it when another view is enlarged.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { damageAt, damageWords } from '../store/clip.js';
import { server, ui, watch } from '../store/state.js';
import { onViews, view as viewNamed } from '../views/views.js';
import { displaybar, onSlide } from './displaybar.js';
import { draftbar } from './draftbar.js';
import { footbars } from './footbars.js';
import { mountOrbitHint } from './freebar.js';
import { headbar } from './headbar.js';
import { interaction, onInteraction } from './interaction.js';
import { notebar } from './notebar.js';
import { largeView } from './scale.js';
import { tintbar } from './tintbar.js';
import { toolbar } from './toolbar.js';
import { isHandleCoveredBy } from './covered_by.js';

/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = ['file', 'damage', 'surface', 'body', 'view', 'pose', 'keys', 'segments', 'draft', 'undo', 'notes'];

const host = document.createElement('div');

export function mountBars() {
  host.className = 'bars';
  mountOrbitHint();
  // A bar clicked with the mouse leaves the keys to the views.
  host.addEventListener('mousedown', (event) => event.preventDefault());
  watch([...SECTIONS, 'u:draftRead', 'u:tool', 'u:layout', 'u:box', 'u:rings', 'u:tab', 'u:menu', 'u:orbited'], draw);
  onViews(draw);
  onInteraction(draw);
  onSlide(draw);
}

function draw() {
  const place = viewNamed(largeView())?.el;
  if (place && host.parentElement !== place) place.append(host);
  host.classList.toggle('quad', ui.layout === 'quad');
  render(server.file && server.view ? bars() : nothing, host);
  for (const bar of host.querySelectorAll('.glass')) {
    // What a draft found is read while the pointer rests where the box was drawn: at the body.
    const rests = bar.id !== 'mdraft' && isHandleCoveredBy(bar);
    bar.classList.toggle('faded', interaction.drag !== null || rests);
  }
}

function bars() {
  return html`${headbar()}${toolbar()}${displaybar()}${tintbar()}${damagebar()}${draftbar()}${notebar()}${footbars()}`;
}

/** What is wrong with the picture, where its frame is damaged. */
function damagebar() {
  const run = damageAt(server.view.frame);
  if (!run) return nothing;
  return html`<div class="glass" id="mdamaged" role="status">${icon('warn')}<span>${damageWords(...run)}</span></div>`;
}
