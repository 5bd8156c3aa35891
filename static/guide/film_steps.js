// The guide for a new film: its lens, the person in it, a draft of every frame, how the camera moved, what to
// confirm. The lens is one of six kinds of camera, by keys 1 to 6, a focal length on a slider, or what the file says.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { cameraFindings, cameraKind, cameraWords, hasFrames, isFindingCamera } from '../actions/camera.js';
import { draftTimeWords, placesWords, smallWords } from '../actions/drafting.js';
import {
  addForStabiliser,
  chooseKind,
  degrees,
  fileWords,
  FOCAL_MM,
  focalSpec,
  isFileOther,
  keepLens,
  kindHere,
  KINDS,
  millimetres,
  useFile,
} from '../actions/lens.js';
import { placesToConfirm } from '../actions/playhead.js';
import { isLooking, isNobodyHere, peopleHere, peopleWords, takePerson } from '../actions/people.js';
import { isReviewing, toggleReview } from '../actions/review.js';
import { isUpKnown, tiltWords } from '../actions/standing.js';
import { shortNumber } from '../controls/arithmetic.js';
import { numberField, slider } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { pendingOr } from '../controls/value.js';
import { draftEverybody, draftFromBox, sizeWords } from '../handles/box.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { view } from '../views/views.js';

/** @typedef {import('../store/shapes.js').Body['presets'][number]} Preset */

export function lensCard() {
  const here = kindHere();
  const [min, max] = FOCAL_MM;
  return html`<div class="lenses" role="radiogroup" aria-label="Kind of camera">
      ${KINDS.map((kind, i) => kindButton(kind, kind === here, i))}
    </div>
    <div class="row focal">
      <label class="mut">35 mm equivalent</label>
      ${slider({ ...focalSpec(), min, max, zero: min, tick: false, log: true, rolls: true })}${numberField(focalSpec())}
    </div>
    ${fileLine()}${stabilised()}
    <div class="row filesays"><span class="mut">Calibrated, or solved elsewhere?</span><span class="sp"></span>
      <button type="button" class="btn sm"
        title="Read the lens, and how the camera moved, from a file of another program"
          @click=${() => perform('importFile')}>Camera file…</button></div>`;
}

/** @param {import('../actions/lens.js').Kind} kind */
function kindButton(kind, isHere, i) {
  return html`<button type="button" class="stack lens ${isHere ? 'on' : ''}" role="radio" aria-checked=${isHere}
    title=${kind.mm ? `${kind.label} (${i + 1})` : `Fitted with the first two keyframes (${i + 1})`}
      @click=${() => chooseKind(kind)}>
    <b>${icon(kind.icon)}${kind.label}</b><span>${kind.detail}</span>
  </button>`;
}

function fileLine() {
  const { lens } = server.file;
  if (!lens) return nothing;
  if (isFileOther()) {
    return html`<div class="row filesays">
      <span class="mut">File says ${millimetres(lens.focal_mm)}</span><span class="sp"></span>
      <button type="button" class="btn sm" @click=${useFile}>Use</button>
    </div>`;
  }
  return html`<div class="row filesays good">${icon('check')}<span><b>From the file</b> ${fileWords()}</span></div>`;
}

/** Where the file or a person named the lens itself, not what the film shows of it. */
function stabilised() {
  const { lens_source: source } = server.camera;
  const isNamed = source === 'file' || KINDS.some(({ mm }) => mm === Math.round(server.camera.focal_mm));
  if (!isNamed || server.camera.lens_is_guess) return nothing;
  return html`<div class="row filesays">
    <span class="mut">Stabilised film shows less than the lens. Add about 10 %.</span><span class="sp"></span>
    <button type="button" class="btn sm" @click=${addForStabiliser}>Add</button>
  </div>`;
}

/** Keys 1 to 6; whether it was one. */
export function lensKey(key) {
  const kind = KINDS[Number(key) - 1];
  if (kind) chooseKind(kind);
  return Boolean(kind);
}

const WIDTH = 264;
const HEIGHT = 246;
/** From the view's lower right corner, above its zoom. */
const ROOM = { right: 12, bottom: 56 };
/** Where the camera stands in the panel, from its left and its top, px. */
const MIDDLE = 140;
const FOOT = 206;
/** How far the fields of view reach from the camera, px. */
const RADIUS = 172;
/** How far they reach to either side at most, px. */
const WIDEST = 122;
/** Where the person stands, as a share of the radius. */
const THERE = 0.62;
/** Lenses to compare with, mm. */
const WIDE = 13;
const TELE = 77;
const USUAL = 26;

/** The panel, over the lower right of the picture. */
export function fan() {
  const { right, bottom } = view('main').el.getBoundingClientRect();
  const mm = pendingOr('lens', server.camera.focal_mm);
  const other = Math.abs(mm - TELE) < 8 ? USUAL : TELE;
  const metres = distance() * (mm / server.camera.focal_mm);
  const place = `left:${right - ROOM.right - WIDTH}px;top:${bottom - ROOM.bottom - HEIGHT}px`;
  return html`<div class="glass fan" style=${place} role="img" aria-label=${`${millimetres(mm)} seen from above`}>
    <svg width=${WIDTH} height=${HEIGHT} aria-hidden="true">
      <text class="h" x="12" y="20">Field of view</text><text class="s" x=${WIDTH - 8} y="20"
        text-anchor="end">from above</text>
      ${slice(WIDE, 'other', 0.87)}${slice(mm, 'here', 1)}${slice(other, 'other', 1)}
      <rect class="camera" x=${MIDDLE - 7} y=${FOOT - 3} width="14" height="10" rx="2" />
      ${person(metres)}
      <text class="here" x=${MIDDLE} y=${FOOT - RADIUS + 18}
        text-anchor="middle">${millimetres(mm)} · ${Math.round(degrees('across', mm))}°</text>
      <text class="s" x="12" y=${FOOT - 40}>${WIDE} mm</text>
      <text class="o" x=${MIDDLE} y=${FOOT - 52} text-anchor="middle">${other} mm</text>
      <text class="s" x="12"
        y=${FOOT + 30}>Same picture with ${other} mm: ${shortNumber((metres * other) / mm, 1)} m away.</text>
    </svg>
  </div>`;
}

function slice(mm, kind, share) {
  const half = ((degrees('across', mm) / 2) * Math.PI) / 180;
  const r = Math.min(RADIUS, WIDEST / Math.sin(half)) * share;
  const [x, y] = [Math.sin(half) * r, Math.cos(half) * r];
  return svg`<path class=${kind} d="M${MIDDLE} ${FOOT}l${-x} ${-y}a${r} ${r} 0 0 1 ${2 * x} 0z" />`;
}

function person(metres) {
  const [x, , z] = isPosed() ? server.pose.root : [0, 0, 1];
  const angle = Math.atan2(x, z);
  const [at, up] = [MIDDLE + Math.sin(angle) * THERE * RADIUS, FOOT - Math.cos(angle) * THERE * RADIUS];
  return svg`<ellipse class="shade" cx=${at} cy=${up} rx="9" ry="4.5" /><circle class="person" cx=${at} cy=${up} r="4"
    />
    <text class="m" x=${at + 14} y=${up + 4}>${shortNumber(metres, 1)} m</text>`;
}

/** Whether somebody has posed the body, or a draft has. */
export const isPosed = () => Boolean(server.pose && !['opening', 'rest'].includes(server.pose.source));

/** Metres to the body as it is posed; before that, to one that is as tall as the picture. */
function distance() {
  if (isPosed()) return server.pose.root[2];
  return ((server.body.height_cm / 100) * server.camera.fy) / server.camera.height;
}

/** What counts as an answer to the question of the lens. */
const ANSWERS = ['person', 'calibration', 'fitted', 'turns', 'guess'];

/** @type {import('./step.js').Step[]} */
const IN_FILM = [
  {
    word: 'Lens',
    title: 'Which lens?',
    text: 'The lens decides how far away the person is. If you do not know, keep what is chosen.',
    done: () => ANSWERS.includes(server.camera?.lens_source),
    again: true,
    content: lensCard,
    beside: fan,
    key: lensKey,
    leave: keepLens,
    hints: [
      ['1–6', 'choose a lens'],
      ['Wheel', 'change the focal length'],
    ],
  },
  {
    word: 'Up',
    title: 'How is the camera tilted?',
    tool: 'horizon',
    text: 'Feet stand on one floor only when this is right. Pull the line onto the horizon, where level ground would end.',
    done: isUpKnown,
    unsure: () => !server.camera.up_is_sure,
    again: true,
    content: upLine,
    choices: [
      {
        label: 'Level camera',
        title: 'It looks straight ahead, neither up nor down',
        act: () => perform('levelCamera'),
        ends: true,
      },
      { label: 'Two verticals', title: 'Drag along two walls, doors or poles', act: () => setUi('tool', 'vertical') },
      { label: 'Don’t know', title: 'The feet say it later, less surely', act: () => {}, ends: true },
    ],
    next: () => (isUpKnown() || sought === server.file?.path ? null : { label: 'Find it', act: findUp }),
    hints: [['Drag', 'the horizon']],
  },
  {
    word: 'Person',
    title: 'Choose the person',
    tool: 'box',
    text: 'Choose a frame that shows the whole body, with the arrow keys. Click the person, or draw a box from head to toes.',
    done: () => Boolean(ui.box) || isDrafting() || isDrafted(),
    again: true,
    content: personLine,
    next: nextOfPerson,
    hints: [
      ['Click', 'take a person'],
      ['Drag', 'draw the box, pull its edges'],
      ['← →', 'choose another frame'],
    ],
    byHand: true,
  },
  {
    word: 'Draft',
    title: 'Pose every frame',
    tool: 'box',
    text: 'Finds the person in every frame and poses the body there. Runs on this computer only.',
    done: () => isDrafted(),
    again: true,
    content: draftButton,
    byHand: true,
  },
  {
    word: 'Camera',
    title: 'Find how the camera moves',
    tool: 'select',
    text: 'The background shows how it pans, tilts, zooms and shakes. Then the floor stays where it is, and feet that stand do not slide.',
    needed: doesCameraMove,
    done: () => cameraKind() !== null,
    again: true,
    content: cameraLine,
    get choices() {
      return cameraKind() === null && !isFindingCamera()
        ? [{ label: 'Skip', title: 'It can be found later, in the Camera tab', act: () => {}, ends: true }]
        : undefined;
    },
    next: () =>
      cameraKind() !== null || isFindingCamera()
        ? null
        : { label: 'Find its motion', act: () => perform('findCamera') },
  },
  {
    word: 'Review',
    title: 'Confirm the draft',
    tool: 'select',
    text: 'Review leads through the places where the draft is unsure: Enter accepts, N goes on.',
    done: () => isDrafted() && placesToConfirm().length === 0,
    again: true,
    content: placesLine,
    next: () => (placesToConfirm().length ? { label: labelOf('review'), act: review } : null),
  },
];

export const DRAFT = IN_FILM.findIndex(({ word }) => word === 'Draft');

/** Those that this film needs. */
export const filmSteps = () => IN_FILM.filter(({ needed }) => !needed || needed());

/** The film in which upright lines were looked for. */
let sought = null;

function findUp() {
  sought = server.file.path;
  perform('findUp');
}

function upLine() {
  if (!isUpKnown()) return nothing;
  const { up_is_sure: isSure } = server.camera;
  return html`<div class="row filesays ${isSure ? 'good' : 'warned'}">${icon(isSure ? 'check' : 'warn')}<span><b>Camera</b> ${tiltWords()}</span></div>`;
}

/** It was found that the camera does not stand still. */
function doesCameraMove() {
  return server.settings?.found_still === false && server.settings.static_camera !== true;
}

function cameraLine() {
  if (isFindingCamera()) {
    return html`<p class="num">${
      server.job.words || `${server.job.title}, ${Math.round(server.job.percent ?? 0)} %`
    }</p>`;
  }
  if (cameraKind() === null) return nothing;
  const found = cameraFindings().find(hasFrames);
  return html`<div class="row filesays ${found ? 'warned' : 'good'}">${icon(found ? 'warn' : 'check')}
    <span>${found?.words ?? cameraWords()}</span></div>`;
}

const isDrafting = () => server.job?.state === 'running' && server.job.kind === 'draft';
const isDrafted = () => Boolean(server.draft);

/** The box first, then whoever was found; what is looked for is waited for. */
function nextOfPerson() {
  if (ui.box) return { label: labelOf('draft'), act: draftFromBox };
  const { length } = peopleHere();
  if (length) {
    return { label: length > 1 && !ui.personHover ? 'Take the tallest' : 'Take this person', act: () => takePerson() };
  }
  return isLooking() ? { label: 'Looking…', act: () => {} } : null;
}

function foundLine() {
  const words = peopleWords();
  return words ? html`<p class="${isNobodyHere() ? 'note warned' : 'note'}">${words}</p>` : nothing;
}

/** All of them at once. */
function everybodyLine() {
  if (peopleHere().length < 2) return nothing;
  return html`<div class="row"><button type="button" class="btn sm" title=${titleOf('draftAll')}
    @click=${draftEverybody}>${labelOf('draftAll')}</button></div>`;
}

function personLine() {
  if (!ui.box) return html`${foundLine()}${everybodyLine()}${heightLine()}${otherLine()}`;
  const small = smallWords();
  return html`<div class="row filesays ${small ? 'warned' : 'good'}">${icon(small ? 'warn' : 'check')}
    <span>${small || html`<b>Person</b> ${sizeWords(ui.box)} px`}</span></div>${heightLine()}`;
}

/** The bodies to choose instead of an adult's. @returns {Preset[]} */
export const otherBodies = () => server.body?.presets.filter(({ kind }) => kind !== 'adult') ?? [];

/** A child is drafted like an adult; an animal or a thing is posed by hand. */
function otherLine() {
  return html`<div class="row others"><span class="note">Somebody else?</span>
    ${otherBodies().map(
      (one) => html`<button type="button" class="btn sm" aria-pressed=${server.body?.preset === one.name}
      title=${one.kind === 'child' ? 'Draft with the proportions of a child' : 'Pose it by hand'}
      @click=${() => takeBody(one)}>${one.label}</button>`,
    )}</div>`;
}

/**
 * Use this body. When it arrives, `followBody` of guide.js shows the guide of its kind.
 * @param {Preset} preset
 */
export function takeBody({ name, kind }) {
  send({ do: 'preset', name });
  if (kind === 'child') return;
  setUi('box', null);
  setUi('tool', 'move');
  if (kind === 'object') takeThing(name);
}

function takeThing(name) {
  send({ do: 'select', part: name });
  setUi('tab', 'part');
  setUi('guidePath', 'thing');
  setUi('guideStep', 0);
}

/** The person's height: the preset's until it is entered. */
function heightLine() {
  const { height_cm: value } = server.body;
  return html`<div class="row height"><label class="mut">Height</label>${numberField({
    key: 'guide-height',
    label: 'Height of the person',
    value,
    unit: 'cm',
    decimals: 0,
    step: 0.5,
    coarse: 5,
    min: LEAST_CM,
    max: MOST_CM,
    title: 'From the soles to the top of the head',
    edit: (cm) => ({ do: 'height', cm }),
  })}<span class="note">If you know it: depth and lengths are right then.</span></div>`;
}

const LEAST_CM = 40;
const MOST_CM = 250;

const said = (words) => (words ? html`<p class="note">${words}</p>` : nothing);

function draftButton() {
  if (isDrafting()) return html`<p class="num">${server.job.words || 'Drafting…'}</p>`;
  const why = whyNot('draft');
  return html`<button type="button" class="btn pri full" aria-disabled=${Boolean(why)} title=${why || nothing}
    @click=${draftFromBox}>${icon('wand')}${labelOf('draft')}</button>${said(why ? `${why}.` : draftTimeWords())}`;
}

/** The guide is at its end: the review goes on by itself. */
function review() {
  setUi('guideStep', null);
  if (!isReviewing()) toggleReview();
}

function placesLine() {
  return placesToConfirm().length ? html`<p class="num">${placesWords()}.</p>` : nothing;
}
