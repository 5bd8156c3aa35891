// The guide, to a draft of a new film or to a pose by hand: a card that ticks its steps off as they are done in
// any way, and gives way to the handles, to what is dragged and to its value. Once the pose is a keyframe it is at
// its end, whichever step was shown.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop, keepsKey } from '../controls/focus.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { isHeld } from '../controls/layout_hold.js';
import { server, ui, setUi, watch } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { isSurface } from '../store/clip.js';
import { onViews, view } from '../views/views.js';
import { interaction, onInteraction } from '../handles/interaction.js';
import { isDrawingTool } from '../handles/sketch.js';
import { isDragCoveredBy } from '../handles/floating.js';
import { carry, covers, coversWords, drawMarks, forgetPulled, mountPulled, placeInCorner } from './places.js';
import { DRAFT, isPosed } from './film_steps.js';
import { ending, isByHand, isDone, isKept, pathByHand, steps, takeWaist } from './steps.js';

const KEY = 'keypose.guide';
const CLOSES_BEFORE_NOT_OFFERED = 3;
/** Of a wide card in its view, clear of the tools and the heading. */
const LEFT = { x: 72, y: 60 };
/** Between the card and the picture it stands beside. */
const GAP_PX = 12;
const PAUSE_MS = 900; // long enough to see the tick
const MEANT_MS = 500;
/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = [
  'guide',
  'file',
  'camera',
  'pose',
  'body',
  'keys',
  'suggest',
  'segments',
  'job',
  'draft',
  'networks',
  'settings',
  'camera_motion',
  'people',
];

let wasDone = false; // what was done before its step was shown does not move it on
let wasKept = false; // nor does a pose that was kept before
let offered = null; // the file the guide was offered for
let timer = 0;
let wentOnAt = -Infinity; // by itself
let corner = null; // where the card stands
let isPutAside = false; // by hand: then it stays there

/** The guide to a pose by hand from its first step, for the present frame, whatever was done before. */
export function openGuide() {
  isPutAside = false;
  setUi('guidePath', pathByHand());
  send({ do: 'begin_guide' });
  show(0);
}

/** Which way leads to a first pose of this body. */
const pathFor = () => (server.body?.is_persons ? 'film' : pathByHand());

/** Another body, also one that undo brings back, may have another way. */
function followBody() {
  if (isOpen() && !isSurface() && ui.guidePath !== 'hand' && ui.guidePath !== pathFor()) offerGuide();
}

/** The guide at the first step that is not done yet; at its end when all are. */
function offerGuide() {
  isPutAside = false;
  setUi('guidePath', pathFor());
  const first = steps().findIndex((step) => !isDone(step));
  show(first < 0 ? steps().length : first);
}

/** Close the guide for this film, at its end and the third time for good; returns whether it was open. */
export function closeGuide() {
  if (!isOpen()) return false;
  const times = currentStep() ? timesClosed() + 1 : CLOSES_BEFORE_NOT_OFFERED;
  if (isDrawingTool(currentStep()?.tool) && isDrawingTool(ui.tool)) setUi('tool', 'select');
  setUi('guideStep', null);
  inBrowser.write(KEY, String(times));
  return true;
}

export function mountGuide() {
  const marks = addOnTop('guide-marks', 'div');
  const card = addOnTop('guide', 'div');
  card.setAttribute('role', 'region');
  card.setAttribute('aria-label', 'First steps');
  const draw = () => {
    render(isOpen() ? coach() : nothing, card);
    if (isOpen()) place(card.querySelector('.coach'));
    // Until it is posed it would stand before the person.
    view('main').el.classList.toggle('unposed', isOpen() && !isByHand() && !isPosed());
    drawMarks(marks, isOpen() && !ui.dragging ? currentStep() : null);
  };
  mountPulled();
  watch(['guide', 'file', 'u:dragging'], notice);
  watch(['body'], followBody);
  watch(['draft'], skipToDraftReview);
  watch(['job'], followDraft);
  addEventListener('keydown', onKey, true); // before the table of keys, and views by number
  watch(
    [
      ...SECTIONS,
      'u:box',
      'u:lookedAt',
      'u:personHover',
      'u:span',
      'u:guideStep',
      'u:layout',
      'u:tool',
      'u:dragging',
      'u:pulled',
    ],
    draw,
  );
  onViews(draw);
  onInteraction(() => isOpen() && fade(card.querySelector('.coach')));
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

/** Of a drafted film: the camera's motion where that is not known, else the review. */
const afterDraft = () => steps().findIndex((step, i) => i > DRAFT && (i === steps().length - 1 || !isDone(step)));

/** A drafted film has its first pose: the step after it is shown. */
function skipToDraftReview() {
  if (!server.draft?.latest || !isOpen()) return;
  if (isByHand()) setUi('guideStep', null);
  else {
    wentOnAt = performance.now();
    show(afterDraft());
  }
}

/** While every frame is drafted, its step is shown. */
function followDraft() {
  const { state, kind } = server.job ?? {};
  const isAsked = isOpen() && !isByHand() && ui.guideStep > 0 && ui.guideStep <= DRAFT;
  if (isAsked && state === 'running' && kind === 'draft') setUi('guideStep', DRAFT);
}

/** Keys of the step, and Enter to go on; elsewhere they are what they always are. */
function onKey(event) {
  const step = currentStep();
  const { key, ctrlKey, altKey, metaKey, repeat } = event;
  if (!isOpen() || !step?.done || ctrlKey || altKey || metaKey || repeat || ui.dragging) return;
  if (ui.sheet || ui.chooser || ui.menu || isTyping(event)) return;
  const drafts = step.tool && ui.box; // by the Enter of handles/box.js
  const goesOn = key === 'Enter' && !keepsKey('Enter') && !drafts;
  if (!goesOn && !step.key?.(key)) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  if (goesOn && !isWaiting()) goFirst();
}

/** What the step began is under way, or the step is so new that the press was meant for the one before. */
const isWaiting = () => isAtWork() || performance.now() - wentOnAt < MEANT_MS;

const isAtWork = () => server.job?.state === 'running';

const isTyping = ({ target }) => target.matches?.('input, textarea, select, [contenteditable]');

/** What the step's first button does. */
function goFirst() {
  const first = currentStep()?.next?.();
  if (first) first.act();
  else goOn();
}

/** On to the next step by hand. */
function goOn() {
  currentStep()?.leave?.();
  show(ui.guideStep + 1);
}

/** The guide to a pose by hand, from its first step. */
function poseByHand() {
  setUi('guidePath', 'hand');
  setUi('tool', 'move');
  show(0);
}

/** What the keys do in this step, for the status bar: [[key, words], …], or null. */
export function guideHints() {
  const { hints, done } = currentStep() ?? {};
  if (!isOpen() || !done || !hints) return null;
  return [
    ...hints,
    ['Enter', ui.box ? 'draft' : 'continue'],
    ['Esc', isDrawingTool(ui.tool) ? 'cancel' : 'close the guide'],
  ];
}

/** On to the next step, or to the end, once the tick was seen. */
function soonOn(step, go = showNextUndoneStep) {
  clearTimeout(timer);
  timer = setTimeout(() => {
    if (currentStep() !== step || ui.dragging || isHeld()) return;
    wentOnAt = performance.now();
    go();
  }, PAUSE_MS);
}

/** A press that was meant for the step before skips none. */
const skip = () => void (performance.now() - wentOnAt > MEANT_MS && showNextUndoneStep());

function showNextUndoneStep() {
  let next = ui.guideStep + 1;
  while (next < steps().length && isDone(steps()[next])) next += 1;
  show(next);
}

const finish = () => show(steps().length);

/** How often it was closed in this browser. Who closes it once may film something else next time. */
const timesClosed = () => Number(inBrowser.read(KEY)) || 0;

const wasClosed = () => timesClosed() >= CLOSES_BEFORE_NOT_OFFERED;

function coach() {
  const step = currentStep();
  const { title, text, choices, content } = step ?? ending();
  const kind = step?.beside ? 'large' : steps()[0].done ? 'film' : '';
  return html`<div class="coach ${kind}" role="dialog" aria-label="Guide" @pointerdown=${lift}>
    <div class="steps">${steps().map(bar)}</div>
    <h3 aria-level="2">${title}</h3>
    <p>${text}</p>
    ${choices ? html`<div class="choices">${choices.map((choice) => choiceButton(step, choice))}</div>` : nothing}
    ${content?.() ?? nothing}
    ${
      step?.byHand
        ? html`<button class="btn ghost sm byhand"
      @click=${poseByHand}>Pose by hand instead</button>`
        : nothing
    }
    <div class="row foot">
      ${
        step
          ? stepFoot(step)
          : html`<span class="sp"></span>
            <button class="btn sm" @click=${closeGuide}>Close guide</button>`
      }
    </div>
  </div>${step?.beside?.() ?? nothing}`;
}

/**
 * @param {import('./step.js').Step} step
 * @param {import('./step.js').Choice} choice
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
    <button class="btn ghost sm" title="Show it again: ?" data-key="Esc" @click=${closeGuide}>
      Close guide
    </button>
    ${
      step.done
        ? continueButton(step)
        : html`<button
      class="btn sm ${done ? 'pri' : ''}"
      title=${done ? 'Next step' : 'Skip this step'}
      @click=${skip}
    >
      Next
    </button>`
    }`;
}

/** The step's own button is the first where it has one. */
function continueButton(step) {
  const own = step.next?.();
  const isFirst = own || step.beside || isDone(step);
  const { label, act } = own ?? { label: isFirst ? 'Continue' : 'Skip', act: goOn };
  const why = isAtWork() ? `${server.job.title} is under way` : '';
  return html`<button class="btn sm ${isFirst ? 'pri' : ''} ${why ? 'off' : ''}" aria-disabled=${why ? 'true' : nothing}
    title=${why || nothing} @click=${() => !why && act()}>
    ${label}<kbd>Enter</kbd>
  </button>`;
}

function bar(step, i) {
  const done = isDone(step) && !step.unsure?.();
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
  if (event.button !== 0 || event.target.closest('button, number-field, slide-bar')) return;
  isPutAside = true;
  carry(event);
}

/**
 * The card keeps its corner while it covers nothing that is needed, and never moves under a drag.
 * Put somewhere by hand it stays there, unless it covers what is to be dragged.
 */
function place(card) {
  if (!ui.dragging) put(card);
  fade(card);
}

function put(card) {
  const step = currentStep();
  if (!isByHand() && !isPutAside && putBeside(card)) return;
  if (step?.beside && !isPutAside) return putLeft(card);
  if (isPutAside && !covers(card, step)) return;
  isPutAside = false;
  corner = placeInCorner(card, step, corner);
}

/** Beside the picture, in which the person may be anywhere; returns whether there is room. */
function putBeside(card) {
  const { right, bottom } = view('main').el.getBoundingClientRect();
  if (innerWidth - right < card.offsetWidth + 2 * GAP_PX) return false;
  card.style.left = `${right + GAP_PX}px`;
  card.style.top = `${bottom - card.offsetHeight - GAP_PX}px`;
  corner = null;
  return true;
}

/** At the left, clear of what stands beside it at the right. */
function putLeft(card) {
  const { left, top } = view('main').el.getBoundingClientRect();
  card.style.left = `${left + LEFT.x}px`;
  card.style.top = `${top + LEFT.y}px`;
  corner = null;
}

/** What is dragged or drawn behind the card, and its value, can be seen through it. */
function fade(card) {
  // The tool of the step itself is in hand all the time: then only while a stroke is drawn.
  const isDrawing = isDrawingTool(ui.tool) && (currentStep()?.tool !== ui.tool || interaction.sketch?.hold);
  const isInTheWay = isDrawing || (card && (isDragCoveredBy(card) || coversWords(card)));
  card?.classList.toggle('behind', Boolean(isInTheWay));
}
