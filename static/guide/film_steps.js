// The guide for a new film: its lens, the person in it, a draft of every frame, what to confirm.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { labelOf, whyNot } from '../actions/actions.js';
import { placesWords, smallWords } from '../actions/drafting.js';
import { keepLens } from '../actions/lens.js';
import { placesToConfirm } from '../actions/playhead.js';
import { isReviewing, toggleReview } from '../actions/review.js';
import { icon } from '../controls/icons.js';
import { sizeWords } from '../handles/box.js';
import { draftFromBox } from '../handles/sketch.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { fan } from './fan.js';
import { lensCard, lensKey } from './lens_step.js';

/** What counts as an answer to the question of the lens. */
const ANSWERS = ['person', 'calibration', 'fitted', 'guess'];

/** @type {import('./steps.js').Step[]} */
export const IN_FILM = [
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
    hints: [['1–6', 'choose a lens'], ['Wheel', 'change the focal length']],
  },
  {
    word: 'Person',
    title: 'Draw a box around the person',
    tool: 'box',
    text: 'From head to toes, in any frame that shows the whole body. The arrow keys choose another frame.',
    done: () => Boolean(ui.box) || isDrafting() || isDrafted(),
    again: true,
    content: personLine,
    next: () => (ui.box ? { label: labelOf('draft'), act: draftFromBox } : null),
    hints: [['Drag', 'draw the box, pull its edges'], ['← →', 'choose another frame']],
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

export const REVIEW = IN_FILM.length - 1;

const isDrafting = () => server.job?.state === 'running' && server.job.kind === 'draft';
const isDrafted = () => Boolean(server.draft);

function personLine() {
  if (!ui.box) return thingLine();
  const small = smallWords();
  return html`<div class="row filesays ${small ? 'warned' : 'good'}">${icon(small ? 'warn' : 'check')}
    <span>${small || html`<b>Person</b> ${sizeWords(ui.box)} px`}</span></div>`;
}

/** Something else than a person is posed by hand, once its sizes are set. */
function thingLine() {
  const things = server.body?.presets.filter((preset) => preset.is_object) ?? [];
  return html`<div class="row"><span class="note">Not a person?</span>
    ${things.map(({ name, label }) => html`<button type="button" class="btn sm" title="Set its sizes and pose it by hand"
      @click=${() => takeThing(name)}>${label}</button>`)}</div>`;
}

function takeThing(name) {
  send({ do: 'preset', name });
  send({ do: 'select', part: name });
  setUi('box', null);
  setUi('tool', 'move');
  setUi('tab', 'part');
  setUi('guidePath', 'thing');
  setUi('guideStep', 0);
}

function draftButton() {
  if (isDrafting()) return html`<p class="num">${server.job.words || 'Drafting…'}</p>`;
  const why = whyNot('draft');
  return html`<button type="button" class="btn pri full" aria-disabled=${Boolean(why)} title=${why || nothing}
    @click=${draftFromBox}>${icon('wand')}${labelOf('draft')}</button>${why ? html`<p class="note">${why}.</p>` : nothing}`;
}

/** The guide is at its end: the review goes on by itself. */
function review() {
  setUi('guideStep', null);
  if (!isReviewing()) toggleReview();
}

function placesLine() {
  return placesToConfirm().length ? html`<p class="num">${placesWords()}.</p>` : nothing;
}
