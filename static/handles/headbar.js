// The head of the large view: which view it is, what stands at this frame, and how its neighbour
// segments are.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { S, U } from '../state.js';
import { send } from '../link.js';
import { icon } from '../icons.js';
import { VIEWS } from '../views.js';
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

export function headbar() {
  const name = largeView();
  return html`<div class="glass" id="mhead">
    <span class="row b what"><kbd>${VIEWS.indexOf(name) + 1}</kbd>${LABELS[name]}</span>
    <span class="vsep"></span>
    ${standing()}
    ${U.layout === 'quad' ? nothing : neighbours().map(chip)}
  </div>`;
}

/** What the pose at this frame is: set, begun, tracked, or not yet anything. */
function standing() {
  const { frame } = S.view;
  const source = S.pose?.source;
  if (source === 'keyframe') {
    return html`<span class="row b what key">${icon('key')}Keyframe ${frame}</span>`;
  }
  if (source === 'draft') {
    return html`<span class="row b what draft">${icon('keyadd')}Frame ${frame}</span>
      <span class="mut say">Posed, press <kbd>K</kbd> to keep</span>`;
  }
  return html`<span class="row b what">Frame ${frame}</span><span class="mut say">${words(source)}</span>`;
}

function words(source) {
  if (source === 'tracked') return 'tracked';
  if (source === 'between') return 'between keyframes';
  if (source === 'held' && S.keys?.frames.length) return `as at keyframe ${nearestKey()}`;
  return 'No keyframe yet';
}

function nearestKey() {
  const { frame } = S.view;
  const away = (key) => Math.abs(key - frame);
  return S.keys.frames.reduce((best, key) => (away(key) < away(best) ? key : best));
}

/** The segments on both sides of a keyframe, or the one that one stands in. */
function neighbours() {
  const { frame } = S.view;
  return (S.segments ?? []).filter(
    ({ first, last, state }) => first <= frame && frame <= last && CHIPS[state],
  );
}

function chip(segment) {
  const [kind, sign] = CHIPS[segment.state];
  const say = verdict(segment);
  const range = `${segment.first}–${segment.last}`;
  const go = target(segment);
  return html`<button class="chip ${kind}" title="${range} ${say}" @click=${() => send({ do: 'go', frame: go })}>
    ${icon(sign)}<span class="num">${range}</span> <em>${say}</em>
  </button>`;
}

function verdict({ state, words: said, go, pass, of }) {
  if (state === 'tracking') return pass == null ? 'tracking' : `pass ${pass} of ${of}`;
  if (state === 'waiting') return 'Waiting';
  if (state === 'check' && go != null && !said.includes('Go to')) return `${said}. Go to ${go}`;
  if (state === 'lost' && go != null && !said.includes('Key frame')) return `${said}. Key frame ${go}`;
  return said;
}

/** Where a click on a chip goes: to the trouble, or to the segment's other end. */
function target({ first, last, go }) {
  if (go != null) return go;
  return S.view.frame === last ? first : last;
}
