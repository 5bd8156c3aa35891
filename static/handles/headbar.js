// The head of the large view: which view it is, what stands at this frame, and how its neighbour
// segments are.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { partNamed } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { keyOf, labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { partKeyAt } from '../actions/limbs.js';
import { beyondKeys, noMotionYet, segmentsHere } from '../actions/tracking.js';
import { icon } from '../controls/icons.js';
import { VERDICTS } from '../controls/verdicts.js';
import { range, roughError } from '../controls/words.js';
import { words as subject } from '../store/subject.js';
import { VIEW_KEYS, VIEW_NAMES } from '../views/views.js';
import { largeView } from './scale.js';

export function headbar() {
  const name = largeView();
  return html`<div class="glass" id="mhead">
    <span class="row b what name" title="Double-click for the free view" @dblclick=${() => setUi('layout', 'free')}><kbd>${VIEW_KEYS[name]}</kbd>${VIEW_NAMES[name]}</span>
    <span class="vsep"></span>
    ${poseStatus()}
    ${server.sizes_preview ? html`<span class="preview">Preview of new sizes</span>` : nothing}
    ${ui.layout === 'quad' ? nothing : chips()}
  </div>`;
}

/** What the pose at this frame is: set, begun, tracked, or not yet anything. */
function poseStatus() {
  const { frame } = server.view;
  const source = server.pose?.source;
  if (source === 'keyframe') {
    return html`<span class="row b what key">${icon('key')}<span class="word">Keyframe</span> ${frame}</span>`;
  }
  if (source === 'draft') {
    return html`<span class="row b what draft">${icon('keyadd')}<span class="word">Frame</span> ${frame}</span>
      <span class="mut say">${server.pose.followed ? 'Tracked ahead' : 'Posed'}, press <kbd>${keyOf('addKeyframe')}</kbd> to keep</span>`;
  }
  const part = partKeyAt(frame);
  if (part) {
    return html`<span class="row b what key">${icon('part')}<span class="word">Part keyframe</span> ${frame}</span>
      <span class="mut say">${part.words}</span>`;
  }
  return html`<span class="row b what"><span class="word">Frame</span> ${frame}</span><span class="mut say">${sourceWords(source)}</span>`;
}

function sourceWords(source) {
  if (source === 'tracked') return subject().done;
  if (source === 'between') return 'between keyframes';
  if (source === 'held' && server.keys?.frames.length) return `same as keyframe ${nearestKey()}`;
  return 'No keyframe yet';
}

function nearestKey() {
  const { frame } = server.view;
  const away = (key) => Math.abs(key - frame);
  return server.keys.frames.reduce((best, key) => (away(key) < away(best) ? key : best));
}

/** Two of them say a word each, one alone its sentence; where to go is never cut. */
function chips() {
  const all = segmentsHere().filter(({ state }) => state !== 'none');
  const way = beyondKeys();
  if (way) return beyond(way);
  return all.map((segment) => chip(segment, all.length > 1));
}

/** Outside the keyframes there is nothing to track between them. */
function beyond(way) {
  const id = way === 'forward' ? 'trackAhead' : 'trackBack';
  const off = whyNot(id);
  if (off) return nothing;
  return html`<button class="chip old" title=${`${noMotionYet(way)}. ${titleOf(id)}`} data-key=${keyOf(id)} @click=${() => perform(id)}>
    ${icon('track')}<em class="say">No motion yet</em><em class="where">${labelOf(id)}</em>
  </button>`;
}

function chip(segment, isShort) {
  const { colour, sign, word } = VERDICTS[segment.state];
  const { say, why = say, where } = verdict(segment);
  const frames = range(segment.first, segment.last);
  const title = `${frames}: ${where ? `${why}. ${where}` : why}`;
  return html`<button class="chip ${colour}" title=${title} aria-label=${title}
    @click=${() => perform('goTo', target(segment))}>
    ${icon(sign)}<span class="num">${frames}</span>
    <em class="say">${isShort ? word || subject().doing : say}</em>
    ${where ? html`<em class="num where">${isShort || why !== say ? `→ ${segment.go}` : where}</em>` : nothing}
  </button>`;
}

/** What is said of a segment, and what to do at which frame, where there is one. */
function verdict({ state, words: full, short, todo, pass, part, px }) {
  if (state === 'tracking') return { say: pass == null ? subject().doing : full };
  if (state === 'waiting') return { say: VERDICTS.waiting.word };
  const label = px === null ? '' : partNamed(part)?.label.toLowerCase();
  const good = state === 'good' ? 'Good, ' : '';
  return { say: label ? `${good}${roughError(px, null)} at the ${label}` : short || full, why: short || full, where: todo };
}

/** Where a click on a chip goes: to the trouble, or to the segment's other end. */
function target({ first, last, go }) {
  if (go != null) return go;
  return server.view.frame === last ? first : last;
}
