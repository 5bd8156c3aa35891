// The library of poses in the inspector: small pictures; a click on one makes it the pose of this frame.

import { html, nothing, render, svg } from '../vendor/lit-html/lit-html.js';
import { perform, titleOf, whyNot } from '../actions/actions.js';
import { actionIcon } from '../actions/buttons.js';
import { deletePose, keptPoses, renamePose } from '../actions/poses.js';
import { iconButton, textField } from '../controls/fields.js';
import { section } from './section.js';

export function poses() {
  const kept = keptPoses();
  return section(
    'Pose library',
    kept.length
      ? html`<ul class="poses">${kept.map(card)}</ul>`
      : html`<p class="note">Keep poses you will want again: <b>+</b> adds the pose of this frame. They are there in every session.</p>`,
    actionIcon('keepPose'),
  );
}

function card(pose) {
  const off = whyNot('insertPose', pose);
  return html`<li class=${`posecard ${off ? 'off' : ''}`}>
    <button type="button" class="posepick" aria-label=${`Insert ${pose.name}`} title=${off || titleOf('insertPose', pose)}
      aria-disabled=${off ? 'true' : nothing} @click=${() => perform('insertPose', pose)}>${picture(pose)}</button>
    <span class="posedo">${actionIcon('insertMirrored', pose)}${iconButton({
      name: 'trash', label: `Delete ${pose.name}`, act: () => deletePose(pose),
    })}</span>
    ${textField({ label: `Name of ${pose.name}`, value: pose.name, act: (text) => renamePose(pose, text), most: 60 })}
  </li>`;
}

/** Elements by the strokes drawn in them: many poses are not compared stroke by stroke with every move of a drag. */
const pictures = new WeakMap();

/** The body in strokes, as it stood before the camera. */
function picture({ strokes }) {
  if (!pictures.has(strokes)) {
    const place = document.createElement('span');
    render(html`<svg viewBox="-6 -6 112 112" aria-hidden="true">${strokes.map(drawStroke)}</svg>`, place);
    pictures.set(strokes, place);
  }
  return pictures.get(strokes);
}

const EDGE = 2.4;
/** A line of no length has no round ends in every browser. */
const LEAST = 0.01;

function drawStroke([side, x0, y0, x1, y1, width]) {
  const path = `M${x0} ${y0}L${x1 + LEAST} ${y1}`;
  return svg`<path class="edge" d=${path} stroke-width=${width + EDGE} /><path class=${side} d=${path} stroke-width=${width} />`;
}
