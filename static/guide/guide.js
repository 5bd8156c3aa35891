// The guide to a first pose: a card that ticks its steps off as they are done in any way, and
// gives way to the handles, to what is dragged and to its value. Once the pose is a
// keyframe it is at its end, whichever step was shown.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from '../controls/elements.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, ui, setUi, watch } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { onViews } from '../views/views.js';
import { onInteraction } from '../handles/interaction.js';
import { isDrawingTool } from '../handles/sketch.js';
import { isDragCoveredBy } from '../handles/covered_by.js';
import { carry, covers, coversWords, drawMarks, forgetPulled, mountPulled, placeInCorner } from './places.js';
import { ending, isDone, isKept, steps, takeWaist } from './steps.js';

const KEY = 'keypose.guide';
const PAUSE_MS = 900; // long enough to see the tick
/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = ['guide', 'file', 'pose', 'body', 'keys', 'suggest', 'segments', 'job'];

let wasDone = false; // what was done before its step was shown does not move it on
let wasKept = false; // nor does a pose that was kept before
let offered = null; // the file the guide was offered for
let timer = 0;
let corner = null; // where the card stands
let isPutAside = false; // by hand: then it stays there

/** The guide from its first step, for the present frame, whatever was done before. */
export function openGuide() {
  isPutAside = false;
  send({ do: 'begin_guide' });
  show(0);
}

/** The guide at the first step that is not done yet; at its end when all are. */
function offerGuide() {
  isPutAside = false;
  const first = steps().findIndex((step) => !isDone(step));
  show(first < 0 ? steps().length : first);
}

/** Close the guide for good; tells whether it was open. */
export function closeGuide() {
  if (!isOpen()) return false;
  setUi('guideStep', null);
  inBrowser.write(KEY, 'closed');
  return true;
}

export function mountGuide() {
  const marks = addOnTop('guide-marks', 'div');
  const card = addOnTop('guide', 'div');
  const draw = () => {
    render(isOpen() ? coach() : nothing, card);
    if (isOpen()) place(card.firstElementChild);
    drawMarks(marks, isOpen() && !ui.dragging ? currentStep() : null);
  };
  mountPulled();
  watch(['guide', 'file', 'u:dragging'], notice);
  watch(['draft'], leaveToDraft);
  watch([...SECTIONS, 'u:guideStep', 'u:layout', 'u:tool', 'u:dragging', 'u:pulled'], draw);
  onViews(draw);
  onInteraction(() => isOpen() && fade(card.firstElementChild));
  addEventListener('resize', () => requestAnimationFrame(draw));
}

function show(number) {
  const step = steps()[number] ?? {};
  if (step.tool) setUi('tool', step.tool);
  if (step.rings) takeWaist();
  if (number !== ui.guideStep) forgetPulled();
  wasDone = isDone(step);
  wasKept = isKept();
  setUi('guideStep', number);
}

const isOpen = () => Boolean(server.file) && Number.isInteger(ui.guideStep);
const currentStep = () => steps()[ui.guideStep];

function notice() {
  if (!server.file || !server.guide) return;
  if (offered !== server.file.path) {
    if (server.guide.first && !wasClosed()) offerGuide();
    else setUi('guideStep', null); // it was of the session before
  }
  offered = server.file.path;
  const step = currentStep();
  if (!step) return;
  if (!isDone(step)) wasDone = false;
  if (!isKept()) wasKept = false;
  if (ui.dragging) return;
  if (isKept() && !wasKept) soonOn(step, finish);
  else if (isDone(step) && !wasDone && !step.again) soonOn(step);
}

/** A drafted film has its first pose: what to confirm leads on. */
function leaveToDraft() {
  if (server.draft?.latest && isOpen()) setUi('guideStep', null);
}

/** On to the next step, or to the end, once the tick was seen. */
function soonOn(step, go = advance) {
  clearTimeout(timer);
  timer = setTimeout(() => currentStep() === step && !ui.dragging && go(), PAUSE_MS);
}

function advance() {
  let next = ui.guideStep + 1;
  while (next < steps().length && isDone(steps()[next])) next += 1;
  show(next);
}

const finish = () => show(steps().length);

const wasClosed = () => inBrowser.read(KEY) === 'closed';

function coach() {
  const step = currentStep();
  const { title, text, choices } = step ?? ending();
  return html`<div class="coach" role="dialog" aria-label="First pose" @pointerdown=${lift}>
    <div class="steps">${steps().map(bar)}</div>
    <h3>${title}</h3>
    <p>${text}</p>
    ${choices
      ? html`<div class="choices">${choices.map((choice) => choiceButton(step, choice))}</div>`
      : nothing}
    <div class="row foot">
      ${step ? stepFoot(step) : html`<span class="sp"></span>
            <button class="btn sm" @click=${closeGuide}>Close guide</button>`}
    </div>
  </div>`;
}

/**
 * @param {import('./steps.js').Step} step
 * @param {import('./steps.js').Choice} choice
 */
function choiceButton(step, { label, title, act, ends }) {
  const choose = () => {
    act();
    if (ends) soonOn(step);
  };
  return html`<button class="btn sm" title=${title} @click=${choose}>${label}</button>`;
}

function stepFoot(step) {
  const done = isDone(step);
  return html`<span class="dim num">Step ${ui.guideStep + 1} of ${steps().length}</span><span class="sp"></span>
    <button class="btn ghost sm" title="Don’t show again" data-key="Esc" @click=${closeGuide}>
      Close guide
    </button>
    <button
      class="btn sm ${done ? 'pri' : ''}"
      title=${done ? 'Next step' : 'Skip this step'}
      @click=${advance}
    >
      Next
    </button>`;
}

function bar(step, i) {
  const done = isDone(step);
  const kind = i === ui.guideStep ? 'c' : '';
  return html`<button
    class="${kind} ${done ? 'd' : ''}"
    aria-current=${i === ui.guideStep ? 'step' : nothing}
    @click=${() => show(i)}
  >
    <i></i><span>${done ? icon('check') : nothing}${step.word}</span>
  </button>`;
}

function lift(event) {
  if (event.button !== 0 || event.target.closest('button')) return;
  isPutAside = true;
  carry(event);
}

/**
 * The card keeps its corner while it covers nothing that is needed, and never moves under a drag.
 * Put somewhere by hand it stays there, unless it covers what is to be dragged.
 */
function place(card) {
  fade(card);
  if (ui.dragging) return;
  const step = currentStep();
  if (isPutAside && !covers(card, step)) return;
  isPutAside = false;
  corner = placeInCorner(card, step, corner);
}

/** What is dragged or drawn behind the card, and its value, can be seen through it. */
function fade(card) {
  const gives = isDrawingTool(ui.tool) || (card && (isDragCoveredBy(card) || coversWords(card)));
  card?.classList.toggle('behind', Boolean(gives));
}
