// What tracking compares the body with: cues, how sure the detector is of each joint, masks. Which
// cues there are, and why one cannot count, is the server's word.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { isOn, keyOf, labelOf, perform, titleOf } from '../actions/actions.js';
import { FEW, fewOf, keypointsHere, percentOf, unsure } from '../actions/keypoints.js';
import { dropdown, iconButton, numberField, switchField, textField } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { openKeypointMenu } from '../handles/keypoints.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { drawingButton, line, section } from './section.js';

/** Nothing where no keypoints are known of this frame. */
export function keypoints() {
  const points = keypointsHere();
  if (points.length === 0) return nothing;
  const rows = ui.allKeypoints ? points : fewOf(points);
  return section(
    'Keypoints here',
    html`<div class="kps" role="group" aria-label="Keypoints here">${rows.map(jointRow)}</div>
    <div class="kps-foot">
      <button type="button" class="btn sm ${isOn('rings') ? 'on' : ''}" aria-pressed=${isOn('rings')}
        title=${titleOf('rings')} data-key=${keyOf('rings') || nothing}
          @click=${() => perform('rings')}>${labelOf('rings')}</button>
      ${
        points.length > FEW
          ? html`<button type="button" class="btn sm ghost" aria-expanded=${Boolean(ui.allKeypoints)}
        @click=${() => setUi('allKeypoints', !ui.allKeypoints)}>${
          ui.allKeypoints ? 'Fewer' : `All ${points.length}`
        }</button>`
          : nothing
      }
    </div>`,
  );
}

function jointRow(point) {
  const { frame } = server.keypoints;
  const open = (event) => {
    event.preventDefault();
    const { left, bottom } = event.currentTarget.getBoundingClientRect();
    openKeypointMenu(point, frame, [left, bottom]);
  };
  const mark = (joint) => () => setUi('keypointHover', joint);
  return html`<button type="button" class="listrow kp ${unsure(point) ? 'unsure' : ''}" aria-haspopup="menu"
    title=${`${point.label}: put back or ignore here. Drag its ring to correct it`}
    @click=${open} @contextmenu=${open} @mouseenter=${mark(point.joint)} @mouseleave=${mark(null)}
    @focus=${mark(point.joint)} @blur=${mark(null)}>
    <span class="cut">${point.label}</span>
    <span class="bar"><i style="width:${Math.round(100 * point.sure)}%"></i></span>
    <span class="num">${percentOf(point)}</span>
  </button>`;
}

export function masks() {
  const list = server.masks ?? [];
  return section(
    'Ignore masks',
    html`${list.map(mask)}${
      list.length
        ? nothing
        : html`<p class="note">
        Cover what moves but is not the body: a passer-by, a screen, a shadow. It counts neither for
        tracking nor for the camera’s motion.
      </p>`
    }
    ${drawMask()}`,
  );
}

/** The button that takes up the mask tool. */
export const drawMask = () =>
  drawingButton('mask', {
    name: 'plus',
    label: 'Draw a mask in the image',
    busy: 'Click the corners, then press Enter',
    title:
      'Cover what moves but is not the body: click around it. It counts neither for tracking nor for the camera’s motion',
  });

function mask(one, index) {
  const here = one.first <= server.view.frame && server.view.frame <= one.last;
  const change = (fields) => ({ do: 'change_mask', index, ...fields });
  return html`<div
    class="listrow mask ${here ? 'here' : ''} ${index === ui.mask ? 'sel' : ''}"
    title=${here ? 'Holds at this frame' : `Does not hold at frame ${server.view.frame}`}
  >
    <button
      type="button"
      class="lk num"
      aria-label=${`Choose mask ${index + 1}`}
      aria-pressed=${index === ui.mask}
      title="Edit its corners in the image"
      @click=${() => choose(one, index, here)}
    >
      ${index + 1}
    </button>
    ${textField({
      label: `Note on mask ${index + 1}`,
      value: one.note,
      placeholder: 'Note',
      act: (note) => send(change({ note })),
    })}
    ${numberField(end(index, 'first', one.first, 0, one.last, change))}<span class="dim">–</span>
    ${numberField(end(index, 'last', one.last, one.first, server.file.frames - 1, change))}
    ${iconButton({
      name: 'trash',
      label: `Delete mask ${index + 1}`,
      act: () => send({ do: 'delete_mask', index }),
    })}
  </div>`;
}

/** A chosen mask shows its corners, which it can only where it holds. */
function choose(one, index, here) {
  setUi('mask', index === ui.mask ? null : index);
  if (!here) send({ do: 'go', frame: one.first });
}

function end(index, side, value, min, max, change) {
  const label = side === 'first' ? 'First frame' : 'Last frame';
  return {
    key: `mask.${index}.${side}`,
    label,
    value,
    min,
    max,
    decimals: 0,
    step: 1,
    coarse: 10,
    edit: (frame) => change({ [side]: Math.round(frame) }),
  };
}

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
      label,
      title: title || label,
      on: isUsed(cue),
      off,
      stays: isLast(cue) ? 'At least one cue stays on' : '',
      act: (on) => send({ do: 'settings', cues: chosen(id, on) }),
    })}
    ${off ? html`<span class="dim cut" title=${off}>${off}</span>` : nothing}
  </div>`;
}

/** Which network finds keypoints; one that is not here says how to add it. */
function network() {
  const chosenOne = server.networks.find((each) => each.chosen);
  const options = server.networks.map(({ id, label, mb, remedy }) => ({
    id,
    label,
    note: remedy || `${mb} MB`,
    off: remedy ? `Not installed. Run ${remedy}` : '',
  }));
  return html`${line(
    'Network',
    dropdown({
      label: 'Network',
      value: chosenOne?.id,
      options,
      title: 'What finds keypoints. A larger one is more exact and slower',
      act: (id) => send({ do: 'settings', network: id }),
    }),
  )}
  ${
    chosenOne?.remedy
      ? html`<p class="note warned">${icon('warn')}<span>${chosenOne.label} is not installed: run <code>${chosenOne.remedy}</code></span></p>`
      : nothing
  }`;
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
