// By what an observed surface is coloured, with its legend; and why there is none at this frame.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { icon } from '../controls/icons.js';

export function tintbar() {
  if (!server.surface) return nothing;
  return html`<div class="glass" id="mtint" role="group" aria-label="Colours of the surface">
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
  return html`<div class="glass" id="mproblem" role="status">${icon('warn')}<span>${server.surface.problem}</span></div>`;
}
