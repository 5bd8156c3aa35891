// What tracking compares the body with: how bright the picture is, where joints are seen in it.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { switchField } from '../controls/fields.js';
import { section } from './section.js';

/** @typedef {'brightness' | 'keypoints'} Cue */

/** @type {{ id: Cue, label: string, title: string }[]} */
const CUES = [
  { id: 'brightness', label: 'Brightness', title: 'Follow how the body’s brightness moves from frame to frame' },
  { id: 'keypoints', label: 'Keypoints', title: 'Compare the body’s joints with those found in each frame' },
];

export function cues() {
  return section(
    'Cues',
    html`${CUES.map(row)}
    <p class="note">
      Keypoints are joints that a detector finds in each frame. Everything runs on this computer.
    </p>`,
  );
}

function row({ id, label, title }) {
  const why = whyNotUsed(id);
  return html`<div class="cue">
    ${switchField({
      label, title, on: isUsed(id), off: why, stays: isLast(id) ? 'At least one cue stays on' : '',
      act: (on) => send({ do: 'settings', cues: chosen(id, on) }),
    })}
    ${why ? html`<span class="dim cut">${why}</span>` : nothing}
  </div>`;
}

/** Why a cue does not count here, whatever is chosen; or ''. */
function whyNotUsed(id) {
  if (id !== 'keypoints') return '';
  if (!server.body.is_persons) return 'Needs a person’s body';
  return server.settings.method === 'paper' ? 'Not in the published method' : '';
}

const isUsed = (id) => server.settings.cues.includes(id) && !whyNotUsed(id);

/** Whether keypoints count, where any are found. */
export const hasKeypoints = () => isUsed('keypoints');

const isLast = (id) => isUsed(id) && !CUES.some((other) => other.id !== id && isUsed(other.id));

/** The cues with one of them switched, in their order. */
function chosen(id, on) {
  return CUES.map((each) => each.id).filter((each) => (each === id ? on : server.settings.cues.includes(each)));
}
