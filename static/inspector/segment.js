// The segment of the present frame: its verdict, the error expected of its parts.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { keyOf } from '../actions/actions.js';
import { actionButton } from '../actions/buttons.js';
import { goTo, stopPlaying } from '../actions/playhead.js';
import { segmentsHere } from '../actions/tracking.js';
import { clamp } from '../controls/arithmetic.js';
import { segmented, shortNumber } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { range, roughError, VERDICTS } from '../controls/words.js';
import { partNamed, select } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { fewestKeys, isSurface, words as subject } from '../store/clip.js';
import { hasKeypoints } from './cues.js';
import { fact, section } from './section.js';

/** A bar this long is full. */
const FULL_PX = 10;

/** The rows of a segment; nothing where nothing is known. */
export function expectedErrors({ first }) {
  const rows = (server.errors ?? []).filter((error) => error.first === first && partNamed(error.part));
  if (rows.length === 0) return nothing;
  return html`<div class="errors" role="group" aria-label="Expected error">
    <h3 aria-level="2">Expected error</h3>
    ${rows.map(row)}
  </div>`;
}

function row({ part: name, frame, px, cm }) {
  const { label, side } = partNamed(name);
  const share = clamp(px / FULL_PX, 0, 1);
  return html`<button
    type="button"
    class="listrow error ${name === server.view.selected ? 'sel' : ''}"
    title=${`Largest at frame ${frame}. Select ${label.toLowerCase()} and go there`}
    @click=${() => visit(name, frame)}
  >
    <span class="cut">${label}</span>
    <span class="bar"><i style="width:${(100 * share).toFixed(0)}%;background:var(--${side})"></i></span>
    <span class="num">${roughError(px, cm)}</span>
  </button>`;
}

function visit(name, frame) {
  stopPlaying();
  select(name);
  goTo(frame);
}

export function segment() {
  const here = segmentsHere();
  if (here.length === 0) return section('Segment', html`<p class="note">${why()}</p>`);
  const one = here.find((each) => each.first === ui.segmentFirst) ?? mostRelevant(here);
  const choice = here.length > 1 ? sides(here, one) : nothing;
  return section(nameOf(one), html`${verdict(one)}${notes(one)}${isSurface() ? distance(one) : measured(one)}`, choice);
}

const nameOf = ({ first, last }) => `Segment ${range(first, last)}`;

/** At a keyframe two segments meet: the one at work is the one to look at. */
function mostRelevant(here) {
  const scored = (each) => each.scores.some(Number.isFinite);
  return here.find((each) => each.state === 'tracking') ?? here.find(scored) ?? here[0];
}

function sides(here, one) {
  return segmented({
    label: 'Segment',
    value: one.first,
    act: (first) => setUi('segmentFirst', first),
    options: here.map((each, i) => ({
      id: each.first,
      label: i ? 'After' : 'Before',
      title: nameOf(each),
    })),
  });
}

function why() {
  const frames = server.keys?.frames ?? [];
  if (frames.length < fewestKeys()) {
    return isSurface()
      ? 'Nothing to fit yet. Add a keyframe first.'
      : `Nothing to track yet. Add ${frames.length ? 'a second keyframe' : 'two keyframes'}.`;
  }
  const { frame } = server.view;
  const side = frame < frames[0] ? `before ${frames[0]}` : `after ${frames.at(-1)}`;
  return `Frames ${side} are outside the keyframes. Add a keyframe there to track them.`;
}

function verdict(one) {
  const { colour, sign } = VERDICTS[one.state] ?? VERDICTS.none;
  return html`<div class="row verdict" role="status">
    <span class="chip ${colour}">
      <span class=${one.state === 'tracking' ? 'turning' : ''}>${icon(sign)}</span><em>${sentence(one)}</em>
    </span>
    ${Number.isInteger(one.go) ? goThere(one.go) : nothing}
  </div>`;
}

/** What else is worth knowing of how it was found. */
function notes(one) {
  if (!one.notes?.length) return nothing;
  return html`<ul class="notes">${one.notes.map((words) => html`<li>${words}</li>`)}</ul>`;
}

function goThere(frame) {
  return actionButton('goTo', frame, { name: undefined, label: `Go to ${frame}` });
}

function sentence(one) {
  if (one.state === 'tracking') return `${subject().doing}, ${one.words || `pass ${one.pass} of ${one.of}`}`;
  return one.words || VERDICTS[one.state]?.word || `Not ${subject().done}`;
}

/** How far apart body and surfaces lie, where they were fitted. */
function distance(one) {
  const metres = one.scores.at(-1);
  if (one.state === 'tracking' || one.state === 'waiting') return nothing;
  if (!Number.isFinite(metres)) return html`<p class="note">Fit with ${keyOf('trackChanged')}.</p>`;
  return fact('Distance', `${shortNumber(1000 * metres, 1)} mm`, 'RMS distance between body and surface');
}

/** What was measured of it; before that, what will be. */
function measured(one) {
  const isNew = one.state === 'none' || one.state === 'outdated';
  const rows = expectedErrors(one);
  if (isNew && rows === nothing && hasKeypoints()) {
    return html`<p class="note">Expected error appears here after tracking.</p>`;
  }
  return html`${rows}${chart(one)}`;
}

// --- the chart: 264 × 72, errors from the left top down to the right

const [LEFT, RIGHT, TOP, BOTTOM] = [24, 258, 8, 54];

function chart(one) {
  if (!one.scores.some(Number.isFinite)) return html`<p class="note">${nothingDrawn(one)}</p>`;
  const many = Math.max(one.of ?? 0, one.scores.length);
  const top = roundUp(Math.max(...one.scores.filter(Number.isFinite)));
  const step = (RIGHT - LEFT - 8) / Math.max(1, many - 1);
  const x = (pass) => LEFT + 8 + step * (pass - 1);
  const y = (score) => BOTTOM - ((BOTTOM - TOP) * Math.min(score, top)) / top;
  return html`<svg class="passes" viewBox="0 0 264 72" role="img" aria-label=${spokenScores(one)}>
      ${[TOP, (TOP + BOTTOM) / 2, BOTTOM].map((at) => svg`<path class="rule" d="M${LEFT} ${at}H${RIGHT + 4}"/>`)}
      <text x=${LEFT - 6} y=${TOP + 4} class="y">${top}</text><text x=${LEFT - 6} y=${BOTTOM + 4} class="y">0</text>
      ${curve(one, x, y, many)}${numbers(many, x)}
    </svg>
    <p class="note">Error per pass, in levels of brightness from 0 to 255. The best pass is kept.</p>`;
}

function nothingDrawn(one) {
  if (one.state === 'tracking' || one.state === 'waiting') return 'No pass is finished yet.';
  if (one.scores.length > 0) return 'Previews do not measure the error.';
  return `Track with ${keyOf('trackChanged')}. The error of each pass appears here.`;
}

function curve(one, x, y, many) {
  const spots = one.scores.map((score, i) => [i + 1, score]).filter(([, score]) => Number.isFinite(score));
  const path = spots.map(([pass, score]) => `${x(pass).toFixed(1)} ${y(score).toFixed(1)}`).join('L');
  const [lastPass, lastScore] = spots.at(-1);
  const kind = one.state === 'tracking' ? 'going' : '';
  const more = kind !== '' && lastPass < many;
  const rest = more ? svg`<path class="rest" d="M${x(lastPass)} ${y(lastScore)}H${x(many)}"/>` : nothing;
  const dot = ([pass, score]) => {
    const best = pass - 1 === one.best;
    return svg`<circle class=${best ? 'best' : ''} cx=${x(pass)} cy=${y(score)} r=${best ? 4 : 3}>
      <title>Pass ${pass}: ${score.toFixed(2)}</title></circle>`;
  };
  return svg`<g class=${kind}>${rest}<path class="line" d=${`M${path}`}/>${spots.map(dot)}</g>`;
}

function numbers(many, x) {
  const every = Math.ceil(many / 12);
  const shown = Array.from({ length: many }, (_, i) => i + 1).filter((pass) => pass === 1 || pass % every === 0);
  return shown.map((pass) => svg`<text class="x" x=${x(pass)} y="70">${pass}</text>`);
}

function spokenScores(one) {
  const known = one.scores.filter((score) => score !== null);
  return `Error per pass: ${known.map((score) => score.toFixed(1)).join(', ')}`;
}

/** The next round number: the scale does not creep while passes come in. */
function roundUp(value) {
  if (!(value > 0)) return 1;
  const unit = 10 ** Math.floor(Math.log10(value));
  return [1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9, 10].map((step) => step * unit).find((round) => round >= value * 0.999);
}
