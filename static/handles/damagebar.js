// What is wrong with the picture, where its frame is damaged.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { damageAt, damageWords } from '../store/damage.js';
import { icon } from '../controls/icons.js';

export function damagebar() {
  const run = damageAt(server.view.frame);
  if (!run) return nothing;
  return html`<div class="glass" id="mdamaged" role="status">${icon('warn')}<span>${damageWords(...run)}</span></div>`;
}
