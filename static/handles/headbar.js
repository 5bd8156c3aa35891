// The head of the large view: which view it is, what stands at this frame, and how its neighbour
// segments are.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { send } from '../store/link.js';
import { icon } from '../controls/icons.js';
import { words as subject } from '../store/subject.js';
import { VIEWS } from '../views/views.js';
import { largeView } from './scale.js';

const LABELS = { main: 'Camera', top: 'Top', side: 'Side', front: 'Front' };

const CHIPS = {
  good: ['good', 'check'],
  check: ['check', 'warn'],
  lost: ['lost', 'lost'],
  tracking: ['track', 'run'],
  waiting: ['old', 'old'],
  outdated: ['old', 'old'],
};

const WORDS = {
  good: 'Good', check: 'Check', lost: 'Lost', waiting: 'Waiting', outdated: 'Outdated',
};

export function headbar() {
  const name = largeView();
  return html`<div class="glass" id="mhead">
    <span class="row b what name"><kbd>${VIEWS.indexOf(name) + 1}</kbd>${LABELS[name]}</span>
    <span class="vsep"></span>
    ${standing()}
    ${ui.layout === 'quad' ? nothing : chips()}
  </div>`;
}

/** What the pose at this frame is: set, begun, tracked, or not yet anything. */
function standing() {
  const { frame } = server.view;
  const source = server.pose?.source;
  if (source === 'keyframe') {
    return html`<span class="row b what key">${icon('key')}<span class="word">Keyframe</span> ${frame}</span>`;
  }
  if (source === 'draft') {
    return html`<span class="row b what draft">${icon('keyadd')}<span class="word">Frame</span> ${frame}</span>
      <span class="mut say">Posed, press <kbd>K</kbd> to keep</span>`;
  }
  return html`<span class="row b what"><span class="word">Frame</span> ${frame}</span><span class="mut say">${words(source)}</span>`;
}

function words(source) {
  if (source === 'tracked') return subject().done;
  if (source === 'between') return 'between keyframes';
  if (source === 'held' && server.keys?.frames.length) return `as at keyframe ${nearestKey()}`;
  return 'No keyframe yet';
}

function nearestKey() {
  const { frame } = server.view;
  const away = (key) => Math.abs(key - frame);
  return server.keys.frames.reduce((best, key) => (away(key) < away(best) ? key : best));
}

/** The segments on both sides of a keyframe, or the one that one stands in. */
function neighbours() {
  const { frame } = server.view;
  return (server.segments ?? []).filter(
    ({ first, last, state }) => first <= frame && frame <= last && CHIPS[state],
  );
}

/** Two of them say a word each, one alone its sentence; where to go is never cut. */
function chips() {
  const all = neighbours();
  return all.map((segment) => chip(segment, all.length > 1));
}

function chip(segment, isShort) {
  const [kind, sign] = CHIPS[segment.state];
  const { say, where } = verdict(segment);
  const range = `${segment.first}–${segment.last}`;
  const title = `${range}: ${where ? `${say}. ${where}` : say}`;
  return html`<button class="chip ${kind}" title=${title} aria-label=${title}
    @click=${() => send({ do: 'go', frame: target(segment) })}>
    ${icon(sign)}<span class="num">${range}</span>
    <em class="say">${isShort ? WORDS[segment.state] ?? subject().doing : say}</em>
    ${where ? html`<em class="num where">${isShort ? `→ ${segment.go}` : where}</em>` : nothing}
  </button>`;
}

/** What is said of a segment, and what to do at which frame, where there is one. */
function verdict({ state, words: said, short, todo, pass }) {
  if (state === 'tracking') return { say: pass == null ? subject().doing : upper(said) };
  if (state === 'waiting') return { say: WORDS.waiting };
  return { say: short || said, where: todo };
}

const upper = (said) => said.charAt(0).toUpperCase() + said.slice(1);

/** Where a click on a chip goes: to the trouble, or to the segment's other end. */
function target({ first, last, go }) {
  if (go != null) return go;
  return server.view.frame === last ? first : last;
}
