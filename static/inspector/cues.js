// What tracking compares the body with: how bright the picture is, where joints are seen in it. Which
// cues there are, and why one cannot count, is the server's word.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { icon } from '../controls/icons.js';
import { dropdown, switchField } from '../controls/fields.js';
import { line, section } from './section.js';

/** @typedef {import('../store/shapes.js').CueHere} CueHere */

export function cues() {
  return section(
    'Cues',
    html`${server.cues.map(row)}
    ${hasKeypoints() ? network() : nothing}
    <p class="note">
      What tracking compares the body with. Everything runs on this computer.
    </p>`,
  );
}

/** @param {CueHere} cue */
function row(cue) {
  const { id, label, title, off } = cue;
  return html`<div class="cue">
    ${switchField({
      label, title: title || label, on: isUsed(cue), off, stays: isLast(cue) ? 'At least one cue stays on' : '',
      act: (on) => send({ do: 'settings', cues: chosen(id, on) }),
    })}
    ${off ? html`<span class="dim cut" title=${off}>${off}</span>` : nothing}
  </div>`;
}

/** Which network finds keypoints; one that is not here says how to add it. */
function network() {
  const chosenOne = server.networks.find((each) => each.chosen);
  const options = server.networks.map(({ id, label, mb, remedy }) => ({
    id, label, note: remedy || `${mb} MB`, off: remedy ? `Not installed. Run ${remedy}` : '',
  }));
  return html`${line('Network', dropdown({
    label: 'Network', value: chosenOne?.id, options, title: 'What finds keypoints. A larger one is more exact and slower',
    act: (id) => send({ do: 'settings', network: id }),
  }))}
  ${chosenOne?.remedy ? html`<p class="note warned">${icon('warn')}<span>${chosenOne.label} is not installed: run <code>${chosenOne.remedy}</code></span></p>` : nothing}`;
}

const isUsed = ({ on, off }) => on && !off;

/** Whether keypoints count, where any are found. */
export const hasKeypoints = () => server.cues.some((cue) => cue.id === 'keypoints' && isUsed(cue));

/** @param {CueHere} cue */
const isLast = (cue) =>
  cue.leads && isUsed(cue) && !server.cues.some((other) => other.id !== cue.id && other.leads && isUsed(other));

/** The cues with one of them switched, in their order. */
function chosen(id, on) {
  return server.cues.filter((cue) => (cue.id === id ? on : cue.on)).map((cue) => cue.id);
}
