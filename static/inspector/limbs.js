// The part keyframe of the present frame: which limbs are exact, while the rest is tracked.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { actionButton, actionIcon } from '../actions/buttons.js';
import { partKeyAt } from '../actions/limbs.js';
import { selectedPart } from '../store/parts.js';
import { section } from './section.js';

export function limbs() {
  const key = partKeyAt();
  if (!key) return nothing;
  const rows = key.limbs.map((limb) => html`<div class="row pinrow">
    <span class=${`dot ${limb.side}`} aria-hidden="true"></span><span class="cut">${limb.label}</span><span class="sp"></span>
    ${actionIcon('unkeyLimb', { frame: key.frame, parts: limb.parts, label: limb.label })}</div>`);
  return section(
    `Part keyframe ${key.frame}`,
    html`${rows}<p class="note">${exact(key)} exact here. The other parts follow tracking.</p>
      <div class="lr">${actionButton('keyWhole', key.frame, { name: undefined })}</div>`,
    selectedPart() ? actionIcon('keyLimb') : nothing,
  );
}

const exact = (key) => (key.limbs.length === 1 && !/s$/.test(key.limbs[0].label) ? 'It is' : 'They are');
