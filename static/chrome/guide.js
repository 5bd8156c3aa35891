// The guide to a first pose: a card that ticks its six steps off as they are done in any way, and
// gives way to the handles, to what is dragged and to what is told of it.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../icons.js';
import { send } from '../link.js';
import { S, U, put, watch } from '../state.js';
import { onViews } from '../views.js';
import { onHold } from '../handles/hold.js';
import { isDrawingTool } from '../handles/sketch.js';
import { isUnderHand } from '../handles/underhand.js';
import { drawMarks } from './guide_marks.js';
import { carry, cornerFor, covers, coversWords } from './guide_place.js';
import { forgetPulled, mountPulled } from './guide_pulled.js';
import { STEPS, ending, takeWaist } from './guide_steps.js';

const KEY = 'keypose.guide';
const PAUSE_MS = 900; // long enough to see the tick
const SECTIONS = ['guide', 'file', 'pose', 'body', 'keys', 'suggest', 'segments', 'job'];

let wasDone = false; // what was done before its step was shown does not move it on
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
  const first = STEPS.findIndex(({ name }) => !S.guide.done[name]);
  show(first < 0 ? STEPS.length : first);
}

/** Close the guide for good; tells whether it was open. */
export function closeGuide() {
  if (!isOpen()) return false;
  put('guideStep', null);
  try {
    localStorage.setItem(KEY, 'closed');
  } catch {
    // Then it is offered once more next time.
  }
  return true;
}

export function mountGuide() {
  const card = document.createElement('div');
  card.id = 'guide';
  const marks = document.createElement('div');
  marks.id = 'guide-marks';
  document.getElementById('screens').append(marks, card);
  const draw = () => {
    render(isOpen() ? coach() : nothing, card);
    if (isOpen()) place(card.firstElementChild);
    drawMarks(marks, isOpen() && !U.dragging ? STEPS[U.guideStep] : null);
  };
  mountPulled();
  watch(['guide', 'file', 'u:dragging'], notice);
  watch([...SECTIONS, 'u:guideStep', 'u:layout', 'u:tool', 'u:dragging', 'u:pulled'], draw);
  onViews(draw);
  onHold(() => isOpen() && fade(card.firstElementChild));
  addEventListener('resize', () => requestAnimationFrame(draw));
}

function show(step) {
  const { name, tool, rings } = STEPS[step] ?? {};
  if (tool) put('tool', tool);
  if (rings) takeWaist();
  if (step !== U.guideStep) forgetPulled();
  wasDone = Boolean(S.guide?.done[name]);
  put('guideStep', step);
}

const isOpen = () => Boolean(S.file) && Number.isInteger(U.guideStep);

function notice() {
  if (!S.file || !S.guide) return;
  if (offered !== S.file.path) {
    if (S.guide.first && !wasClosed()) offerGuide();
    else put('guideStep', null); // it was of the session before
  }
  offered = S.file.path;
  const step = STEPS[U.guideStep];
  if (!step) return;
  if (!S.guide.done[step.name]) wasDone = false;
  else if (!wasDone && !step.again && !U.dragging) soonOn(step);
}

/** On to the next step, once the tick was seen. */
function soonOn(step) {
  clearTimeout(timer);
  timer = setTimeout(() => STEPS[U.guideStep] === step && !U.dragging && advance(), PAUSE_MS);
}

function advance() {
  const done = S.guide?.done ?? {};
  let next = U.guideStep + 1;
  while (next < STEPS.length && done[STEPS[next].name]) next += 1;
  show(next);
}

function wasClosed() {
  try {
    return localStorage.getItem(KEY) === 'closed';
  } catch {
    return false;
  }
}

function coach() {
  const step = U.guideStep;
  const { title, text, choices } = STEPS[step] ?? ending();
  return html`<div class="coach" role="dialog" aria-label="First pose" @pointerdown=${lift}>
    <div class="steps">${STEPS.map((each, i) => bar(each, i))}</div>
    <h3>${title}</h3>
    <p>${text}</p>
    ${choices
      ? html`<div class="choices">${choices.map((choice) => choiceButton(STEPS[step], choice))}</div>`
      : nothing}
    <div class="row foot">
      ${step < STEPS.length ? stepFoot(step) : html`<span class="sp"></span>
            <button class="btn sm" @click=${closeGuide}>Close guide</button>`}
    </div>
  </div>`;
}

function choiceButton(step, { label, title, act, ends }) {
  const choose = () => {
    act();
    if (ends) soonOn(step);
  };
  return html`<button class="btn sm" title=${title} @click=${choose}>${label}</button>`;
}

function stepFoot(step) {
  const isDone = Boolean(S.guide?.done?.[STEPS[step].name]);
  return html`<span class="dim num">Step ${step + 1} of ${STEPS.length}</span><span class="sp"></span>
    <button class="btn ghost sm" title="Close for good   Esc" @click=${closeGuide}>
      Close guide
    </button>
    <button
      class="btn sm ${isDone ? 'pri' : ''}"
      title=${isDone ? 'On to the next step' : 'Leave it as it is'}
      @click=${advance}
    >
      Next
    </button>`;
}

function bar({ name, word }, i) {
  const isDone = Boolean(S.guide?.done?.[name]);
  const kind = i === U.guideStep ? 'c' : '';
  return html`<button
    class="${kind} ${isDone ? 'd' : ''}"
    aria-current=${i === U.guideStep ? 'step' : nothing}
    @click=${() => show(i)}
  >
    <i></i><span>${isDone ? icon('check') : nothing}${word}</span>
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
  if (U.dragging) return;
  const step = STEPS[U.guideStep];
  if (isPutAside && !covers(card, step)) return;
  isPutAside = false;
  const { name, x, y } = cornerFor(card, step, corner);
  corner = name;
  card.style.left = `${x}px`;
  card.style.top = `${y}px`;
}

/** What is dragged or drawn behind the card, and what is told of it, can be seen through it. */
function fade(card) {
  const gives = isDrawingTool(U.tool) || (card && (isUnderHand(card) || coversWords(card)));
  card?.classList.toggle('behind', Boolean(gives));
}
