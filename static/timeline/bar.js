// The bar over the timeline: going from frame to frame, the frame as a number to type over, what to key
// next, how the segments stand.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { keyOf, labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { actionIcon } from '../actions/buttons.js';
import { applySizes, isPreview, outdatedWords } from '../actions/proposals.js';
import { bodyAhead, leftToDo } from '../actions/bodies.js';
import { placesWords, reasonOf } from '../actions/drafting.js';
import { frame, goTo, placeAhead, stopPlaying, isKey, keyFrames } from '../actions/playhead.js';
import { isElsewhere, isReviewing, place as placeToReview, places as placesToReview } from '../actions/review.js';
import { chooseSpeed, rateWords, SPEEDS, speedWords } from '../actions/playing.js';
import { isUnderWay, noMotionYet } from '../actions/tracking.js';
import { contradicted, contradictions, proposedPins } from '../actions/pins.js';
import { partNamed } from '../store/parts.js';
import { count, VERDICTS } from '../controls/words.js';
import { dropdown } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { frameCount, isSurface, lastFrame, words as subject } from '../store/clip.js';
import { server, setUi, ui } from '../store/state.js';
import { drawZoomHint } from './opening.js';

/** @param {import('../actions/actions.js').ActionId} id */
const button = (id, looks = {}) => actionIcon(id, undefined, { size: '', ...looks });

export function drawBar() {
  if (!server.file) return nothing;
  return html`${transport()}${drawSuggestion()}<span class="sp"></span>${counts()}${notes()}${drawZoomHint()}${right()}`;
}

function transport() {
  return html`
    ${button('firstFrame')}${button('previousKeyframe')}${button('previousFrame')}${button('play')}
    ${button('nextFrame')}${button('nextKeyframe')}${button('lastFrame')}
    ${button('loop')}${speed()}
    ${frameBox()}
    ${
      isKey(frame())
        ? actionIcon('deleteKeyframe', frame(), { size: '', pressed: true })
        : button('addKeyframe', { pressed: false })
    }
    ${keyFrames().length > 0 ? button('middle') : nothing}
    <span class="vsep"></span>`;
}

/** As it plays now, and to choose from. */
const speed = () =>
  dropdown({
    kind: 'ghost',
    label: 'Speed',
    title: 'How fast to play',
    text: rateWords(),
    value: String(ui.speed),
    options: SPEEDS.map((each) => ({ id: String(each), label: speedWords(each) })),
    act: (id) => chooseSpeed(Number(id)),
  });

const SUGGESTION_ICONS = { good: 'check', track: 'track', look: 'warn', confirm: 'flag' };

/** What helps most now: bold what to do, then why, then a button that does it. While it is being
 * done, how far it is. */
function drawSuggestion() {
  if (isPreview()) return newSizes();
  if (placeToReview() && ui.tool !== 'box') return reviewing(placeToReview());
  if (isReviewing() && !['track', 'pose'].includes(server.suggest?.kind)) return nothing;
  if (ui.reviewLeft && placesToReview().length) return interrupted();
  if (!confirmation() && proposedPins().length) return drawProposals();
  if (!confirmation() && contradictions().length) return drawContradictions();
  const suggest = confirmation() ?? nextBody() ?? server.suggest;
  if (!suggest) return html`<div class="row sug none"></div>`;
  const atWork = isUnderWay(suggest);
  const { title, words } = atWork ? server.job : { title: suggest.title, words: detailOf(suggest) };
  const buttons = atWork ? html`<span class="pad"></span>` : suggestionButton(suggest);
  return strip(
    suggest.kind,
    suggest.sign ?? SUGGESTION_ICONS[suggest.kind] ?? 'keyadd',
    title,
    words,
    buttons,
    `${title}. ${words}`,
  );
}

const strip = (
  kind,
  sign,
  title,
  why,
  buttons,
  tip = `${title} ${why}`,
) => html`<div class=${`row sug ${kind}`} role="status" title=${tip}>
  ${icon(sign)}<span class="tx"><b>${title}</b> <span class="mut">${why}</span></span>${buttons}</div>`;

/** Where nothing is left to mend, how far the motion reaches comes first: the end of a long line is cut. */
const detailOf = ({ kind, detail, ahead }) => (kind === 'good' && ahead ? `${noMotionYet(ahead)}. ${detail}` : detail);

/** New sizes wait for an answer before anything else. */
const newSizes = () =>
  strip(
    'preview',
    'size',
    'New sizes fit better.',
    outdatedWords(),
    html`<button class="btn sm pri" @click=${applySizes}>Apply<kbd>Enter</kbd></button>`,
  );

/** A place is looked at; the answer is given here as well. */
function reviewing({ kind, label, frame: at, reason, cause }) {
  const inDepth = cause === 'depth';
  const asked =
    kind === 'draft'
      ? 'Is the draft right here?'
      : `Is the ${label.toLowerCase()} right ${inDepth ? 'in depth' : 'here'}?`;
  const answers = `${inDepth ? 'Look from the side: ' : ''}Enter accepts, drag corrects.`;
  const [title, why] = isElsewhere() ? [`In review: frame ${at}`, label] : [asked, answers];
  const buttons = [
    primary('acceptPlace', labelOf('acceptPlace')),
    primary('nextPlace', 'Next', labelOf('nextPlace'), 'ghost'),
  ];
  return strip('', 'flag', title, why, buttons, `Frame ${at}: ${reason}`);
}

/** The review was closed before its end. */
const interrupted = () =>
  strip(
    '',
    'flag',
    `Review: ${placesToReview().length} left`,
    '',
    html`
  <button class="btn sm pri"
    @click=${() => perform('continueReview')}>${labelOf('continueReview')}<kbd>${keyOf('review')}</kbd></button>
  <button class="btn sm ghost" title="Shift R opens the review again"
    @click=${() => setUi('reviewLeft', false)}>Dismiss</button>`,
  );

/** Pins wait to be accepted. */
const drawProposals = () =>
  strip(
    'proposed',
    'anchor',
    `${count(proposedPins().length, 'pin')} proposed.`,
    `The ${proposedWord()} still in these frames.`,
    [small('dismissPins', 'ghost'), ...orStand('acceptPins')],
  );

/** "feet stand", "left foot stands", "hands and feet stand". */
function proposedWord() {
  const shorts = [...new Set(proposedPins().map(({ part }) => partNamed(part)?.short.toLowerCase() ?? part))];
  const isOne = new Set(proposedPins().map(({ part }) => part)).size === 1;
  if (isOne) return `${proposedPins()[0].label.toLowerCase()} stands`;
  return shorts.every((short) => short === 'foot') ? 'feet stand' : 'hands and feet stand';
}

/** Pins hold a part where keyframes do not have it: the body jerks from one to the other. */
const drawContradictions = () =>
  strip(
    'look',
    'warn',
    `Pins contradict ${count(contradicted().length, 'keyframe')}.`,
    `${contradictions()[0].words}.`,
    orStand('softKeys'),
  );

/**
 * That, and first of all standing on the floor where it can be done.
 * @param {import('../actions/actions.js').ActionId} id
 */
const orStand = (id) => (whyNot('stand') ? [small(id, 'pri')] : [small(id, 'ghost also'), small('stand', 'pri')]);

/** @param {import('../actions/actions.js').ActionId} id */
const small = (id, kind) =>
  html`<button class="btn sm ${kind}" title=${titleOf(id)} @click=${() => perform(id)}>${labelOf(id)}</button>`;

/** A draft waits to be confirmed before anything else. */
function confirmation() {
  const place = placeAhead();
  if (!place) return null;
  return {
    kind: 'confirm',
    ahead: null,
    frame: place.frame,
    title: placesWords(),
    detail: `Next: frame ${place.frame}. ${reasonOf(place)}`,
  };
}

/** Another body waits. */
function nextBody() {
  const body = bodyAhead();
  if (!body) return null;
  const kind = body.places.length ? 'confirm' : body.open ? 'track' : 'look';
  return {
    kind: 'body',
    frame: null,
    sign: SUGGESTION_ICONS[kind],
    title: `${body.name}: ${leftToDo(body)}`,
    detail: '',
    ahead: null,
  };
}

function suggestionButton({ frame: to, kind, ahead }) {
  if (kind === 'body') return primary('suggestedFrame', 'Go', titleOf('poseBody'));
  if (kind === 'track') return primary('trackChanged', subject().verb);
  const isAbout = kind === 'key' || kind === 'look';
  if (ahead && !isAbout) return aheadButton(ahead);
  const go =
    to === null || to === undefined || to === frame()
      ? html`<span class="pad"></span>`
      : primary('suggestedFrame', 'Go', labelOf('goTo', to));
  return html`${ahead ? aheadButton(ahead, 'ghost') : nothing}${go}`;
}

/** Where the keyframes end, the body can be followed on. @param {'forward' | 'backward'} way @param {string} [kind] */
function aheadButton(way, kind) {
  const id = way === 'forward' ? 'trackAhead' : 'trackBack';
  return primary(id, labelOf(id), `${labelOf(id)}: ${noMotionYet(way)}`, kind);
}

/** @param {import('../actions/actions.js').ActionId} id */
function primary(id, word, label = labelOf(id), kind = 'pri') {
  const why = whyNot(id);
  return html`<button class="btn sm ${kind} ${why ? 'off' : ''}" aria-disabled=${why ? 'true' : nothing}
    title=${why || label} @click=${() => perform(id)}
    >${word}<kbd aria-hidden="true">${keyOf(id)}</kbd></button>`;
}

/** How many segments are good, to check and lost, each in its own place; a press goes to the next of them. */
function counts() {
  const states = (server.segments ?? []).map((segment) => segment.state);
  const found = ['good', 'check', 'lost'].map((state) => [states.filter((s) => s === state).length, state]);
  if (states.length === 0) return nothing;
  return html`<span class="counts">${found.map((each) => drawCount(...each))}</span>`;
}

function drawCount(number, state) {
  if (number === 0) return html`<span class="row count ${state}"></span>`;
  const word = state === 'check' ? 'to check' : state;
  const inside = html`${icon(VERDICTS[state].sign)}${number}<span class="word"> ${word}</span>`;
  const words = `${number} ${word}`;
  if (state === 'good') return html`<span class="row count good" title=${words}>${inside}</span>`;
  return html`<button class=${`row count ${state}`} aria-label=${`${words}, go to the next`}
    title=${titleOf('nextProblem', state)} data-key=${keyOf('nextProblem')}
    @click=${() => perform('nextProblem', state)}>${inside}</button>`;
}

/** How many notes there are; a press lists them. */
function notes() {
  const { length } = server.notes ?? [];
  if (length === 0) return nothing;
  return html`<button class="row count noted" title=${labelOf('notes')}
    aria-label=${`${count(length, 'note')}, list them`}
    @click=${() => perform('notes')}>${icon('note')}${length}</button>`;
}

function right() {
  if ((server.segments ?? []).length === 0 || frameCount() < 2) return nothing;
  const choice = (name, label, title) => html`<button title=${title}
    aria-pressed=${String(ui.chart === name)} @click=${() => setUi('chart', name)}>${label}</button>`;
  const charts = html`<div class="seg" role="group" aria-label="Chart">
      ${choice('angle', 'Angle', 'Angle of the selected part')}
      ${choice('score', 'Error', 'Error per pass of this segment')}</div>`;
  return html`${isSurface() ? nothing : charts}
    <span class=${`fold${ui.lanes ? '' : ' folded'}`}>${button('lanes')}</span>
    ${button('zoomToInterval')}`;
}

function frameBox() {
  const digits = String(lastFrame()).length;
  return html`<label class="row fbox" title="Type a frame, or +5 and -5">
    ${icon('film', 'width:14px;color:var(--t3)')}
    <input aria-label="Frame" inputmode="numeric" autocomplete="off" spellcheck="false"
      style=${`width:${Math.max(2, digits)}ch`} @focus=${(event) => event.target.select()}
      @keydown=${onFrameKey} @blur=${(event) => show(event.target)} />
    <span class="dim">/ ${lastFrame()}</span></label>`;
}

/** Write the playhead's frame into the box; never while someone types in it. */
export function show(input) {
  if (input === null || document.activeElement === input) return;
  input.value = String(frame());
}

function onFrameKey(event) {
  const input = event.target;
  event.stopPropagation();
  if (event.key === 'Escape') {
    input.blur();
  } else if (event.key === 'Enter') {
    const to = frameTyped(input.value.trim());
    stopPlaying();
    if (to !== null) goTo(to);
    input.blur();
  } else if (event.key === 'ArrowUp' || event.key === 'ArrowDown') {
    event.preventDefault();
    goTo(frame() + (event.key === 'ArrowUp' ? 1 : -1));
    input.value = String(frame());
    input.select();
  }
}

function frameTyped(text) {
  if (!/^[+\-−]?\d+$/.test(text)) return null;
  const number = Number(text.replace('−', '-'));
  return /^\d/.test(text) ? number : frame() + number;
}
