// The Part tab: the selected part's pose and sizes, limbs keyed alone, kept poses.

import { html, nothing, render, svg } from '../vendor/lit-html/lit-html.js';
import { perform, titleOf, whyNot } from '../actions/actions.js';
import { actionButton, actionIcon } from '../actions/buttons.js';
import { deletePose, keptPoses, renamePose } from '../actions/copying.js';
import { partKeyAt } from '../actions/parts.js';
import { iconButton, textField } from '../controls/fields.js';
import { send } from '../store/link.js';
import { selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';
import { isSurface } from '../store/clip.js';
import { bonds } from './bonds.js';
import { floor, pins, pinsComeFirst } from './pins.js';
import { rotation } from './rotation.js';
import { measure, section } from './section.js';
import { size } from './size.js';

export function limbs() {
  const key = partKeyAt();
  if (!key) return nothing;
  const rows = key.limbs.map(
    (limb) => html`<div class="row pinrow">
    <span class="dot"
      style="background:var(--${limb.side})"></span><span class="cut">${limb.label}</span><span class="sp"></span>
    ${actionIcon('unkeyLimb', { frame: key.frame, parts: limb.parts, label: limb.label })}</div>`,
  );
  return section(
    `Part keyframe ${key.frame}`,
    html`${rows}<p class="note">${exact(key)} exact here. The other parts follow tracking.</p>
      <div class="lr">${actionButton('keyWhole', key.frame, { name: undefined })}</div>`,
    selectedPart() ? actionIcon('keyLimb') : nothing,
  );
}

const exact = (key) => (key.limbs.length === 1 && !/s$/.test(key.limbs[0].label) ? 'It is' : 'They are');

const NEAREST_M = 0.05;

export function position() {
  // The camera's y runs down; people say how high.
  const rows = [
    { label: 'Across', axis: 'x', sign: 1, title: 'To the right of the image centre' },
    { label: 'Up', axis: 'y', sign: -1, title: 'Above the image centre' },
    { label: 'Depth', axis: 'z', sign: 1, title: 'Away from the camera', min: NEAREST_M },
  ];
  return section(
    'Position',
    html`${rows.map(coordinate)}`,
    iconButton({
      name: 'reset',
      label: 'Move to the image centre',
      act: () => send({ do: 'root', x: 0, y: 0 }),
      off: server.pose ? '' : 'No pose at this frame',
    }),
  );
}

/** @param {{ label: string, axis: string, sign: number, title: string, min?: number }} row */
function coordinate({ label, axis, sign, title, min }) {
  const value = server.pose ? sign * server.pose.root['xyz'.indexOf(axis)] : null;
  return measure({
    key: `${server.view.frame}.root.${axis}`,
    label,
    value,
    unit: 'm',
    decimals: 2,
    step: 0.01,
    coarse: 0.1,
    min,
    title: `${title}: drag sideways or type`,
    edit: (metres) => ({ do: 'root', [axis]: sign * metres }),
    off: server.pose ? '' : 'No pose at this frame',
  });
}

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
    <button type="button" class="posepick" aria-label=${`Insert ${pose.name}`}
      title=${off || titleOf('insertPose', pose)}
      aria-disabled=${off ? 'true' : nothing} @click=${() => perform('insertPose', pose)}>${picture(pose)}</button>
    <span class="posedo">${actionIcon('insertMirrored', pose)}${iconButton({
      name: 'trash',
      label: `Delete ${pose.name}`,
      act: () => deletePose(pose),
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
  return svg`<path class="edge" d=${path} stroke-width=${width + EDGE} /><path class=${side} d=${path}
    stroke-width=${width} />`;
}

export function partTab() {
  const part = selectedPart();
  if (!part) return html`${limbs()}${poseFields()}${poses()}`;
  const pinned = isSurface() ? nothing : html`${bonds(part)}${pins(part)}${floor(part)}`;
  const isFirst = pinsComeFirst(part);
  return html`${limbs()}${isFirst ? pinned : nothing}${part.parent ? nothing : position()}${rotation(part)}${poseFields()}${size(part)}${isFirst ? nothing : pinned}${poses()}`;
}

const POSES = /** @type {const} */ ([
  'fitPose',
  'keyLimb',
  'useTracked',
  'pasteMirrored',
  'swapSides',
  'turnInDepth',
  'copyPrevious',
  'copyNext',
]);

/** Poses taken over whole: fitted, tracked, copied from the keyframes around, mirrored, at rest. */
function poseFields() {
  return section(
    'Pose',
    html`<div class="lr">
      ${POSES.map((id) => actionButton(id, undefined, { name: undefined }))}
    </div>`,
    html`${actionIcon('copyPose')}${actionIcon('pastePose')}${actionIcon('resetPose')}`,
  );
}
