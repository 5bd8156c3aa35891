// How the film's camera moves: what is known, finding it, what is doubtful, where it was corrected.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { actionBox, actionButton } from '../actions/buttons.js';
import {
  cameraFindings,
  cameraKeys,
  cameraKind,
  cameraWords,
  hasFrames,
  isCameraUnknown,
  isFindingCamera,
  motion,
  visitFinding,
} from '../actions/camera.js';
import { goTo, stopPlaying } from '../actions/playhead.js';
import { iconButton, segmented } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { server } from '../store/state.js';
import { drawMask } from './cues.js';
import { drawingButton, line, measure, section } from './section.js';

/** @typedef {import('../store/shapes.js').CameraFinding} CameraFinding */

const KINDS = /** @type {const} */ ({ static: 'cameraStands', turns: 'cameraTurns', moves: 'cameraMoves' });

export function cameraMotion() {
  return section(
    'Motion',
    html`${known()}${line('Camera', kinds())}${finding()}${points()}${ways()}${doubts()}${corrections()}${leave()}`,
  );
}

/** In one line; while it is being found, how far that is. */
function known() {
  if (isFindingCamera()) {
    const { title, words, percent } = server.job;
    return html`<p class="note icons"
      role="status">${icon('run')}<span>${title}: <span class="num">${words || `${Math.round(percent ?? 0)} %`}</span></span></p>`;
  }
  const [kind, sign] = isCameraUnknown() ? ['warned', 'warn'] : cameraKind() ? ['good', 'check'] : ['', 'camc'];
  return html`<p class=${`note icons ${kind}`} role="status">${icon(sign)}<span>${cameraWords()}</span></p>`;
}

function kinds() {
  const option = (id) => ({ id, label: labelOf(KINDS[id]), title: titleOf(KINDS[id]), off: whyNot(KINDS[id]) });
  return segmented({
    label: 'How the camera moves',
    value: cameraKind(),
    options: Object.keys(KINDS).map(option),
    act: (id) => perform(KINDS[id]),
  });
}

function finding() {
  if (isFindingCamera()) return actionButton('cancel', undefined, { kind: 'full' });
  return actionButton('findCamera', undefined, { kind: isCameraUnknown() ? 'full pri' : 'full' });
}

/** Whether points of the background are shown, and how many agree here. */
function points() {
  if (whyNot('background')) return nothing;
  return html`${actionBox('background')}${server.view.background ? counted() : nothing}`;
}

function counted() {
  if (!server.background) {
    return html`<p class="note">The points are no longer there. ${labelOf('findCamera')} again to see them.</p>`;
  }
  const { good } = server.background;
  const agree = good.filter(Boolean).length;
  if (!good.length) return html`<p class="note">None could be followed here.</p>`;
  return html`<p class="row note legend">${sign('agrees')}<span><b class="num">${agree}</b> agree</span>
    ${sign('refused')}<span><b class="num">${good.length - agree}</b> left out</span></p>`;
}

const sign = (kind) => html`<svg class=${`bgsign ${kind}`} viewBox="-5 -5 10 10" aria-hidden="true">
  <path d=${kind === 'agrees' ? 'M0 0h0' : 'M-3-3l6 6M3-3l-6 6'} /></svg>`;

/** How far it went, found or asked for: until that is known, its path has no scale. */
function ways() {
  const all = motion()?.ways ?? [];
  return all.map((way) =>
    measure({
      key: `camera-way-${way.first}`,
      label: 'How far the camera went from where it began',
      value: way.metres,
      text: all.length > 1 ? `Went, ${way.first}–${way.last}` : 'Went',
      unit: 'm',
      decimals: 2,
      step: 0.1,
      coarse: 1,
      min: 0.01,
      max: 10000,
      title:
        way.off_m === null
          ? 'From where it was at first to the farthest place. Gives its path a scale'
          : `± ${way.off_m} m, by where feet stand. Type it if you know it better`,
      edit: (metres) => ({ do: 'camera_far', first: way.first, metres }),
    }),
  );
}

/** What is not known of it, or not as surely. */
function doubts() {
  const found = cameraFindings();
  if (!found.length) return nothing;
  return html`<ul class="doubts" aria-label="What is doubtful of the camera’s motion">${found.map(doubt)}</ul>
    ${found.some(({ kind }) => kind === 'not_rigid') ? drawMask() : nothing}`;
}

/** @param {CameraFinding} found */
function doubt(found) {
  if (!hasFrames(found)) return html`<li class="note icons">${icon('warn')}<span>${found.words}</span></li>`;
  return html`<li><button type="button" class="listrow doubt" title=${`Go to ${found.first}`}
    @click=${() => visitFinding(found)}>
    ${icon('warn')}<span>${found.words}</span></button></li>`;
}

function corrections() {
  if (!motion()) return nothing;
  return html`${
    cameraKeys().length
      ? html`<h3 aria-level="3" class="camkeys-head">Corrected at</h3>
    <ul class="camkeys">${cameraKeys().map(corrected)}</ul>`
      : nothing
  }
    ${drawingButton('cameraHorizon', {
      name: 'floor',
      label: labelOf('cameraHorizon'),
      busy: 'Pull the line onto the horizon',
      title: titleOf('cameraHorizon'),
      off: whyNot('cameraHorizon'),
    })}
    ${drawingButton('cameraMatch', {
      name: 'link',
      label: labelOf('cameraMatch'),
      busy: 'Mark points in two frames',
      title: titleOf('cameraMatch'),
      off: whyNot('cameraMatch'),
    })}`;
}

function corrected(at) {
  const isHere = at === server.view.frame;
  return html`<li class="listrow camkey ${isHere ? 'sel' : ''}">
    <button type="button" class="name" title=${`Go to ${at}`} aria-current=${isHere ? 'true' : nothing}
      @click=${() => visit(at)}>Frame <span class="num">${at}</span></button>
    <span class="sp"></span>
    ${iconButton({
      name: 'trash',
      label: `Delete the correction at frame ${at}`,
      act: () => perform('deleteCameraKey', at),
    })}</li>`;
}

function visit(at) {
  stopPlaying();
  goTo(at);
}

const leave = () =>
  whyNot('forgetCamera') ? nothing : actionButton('forgetCamera', undefined, { kind: 'full ghost' });
