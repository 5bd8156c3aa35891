// The bar over the timeline: going from frame to frame, the frame as a number to type over, what to key
// next, how the segments stand.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../store/state.js';
import { send } from '../store/link.js';
import { isSurface, words as subject } from '../store/subject.js';
import { icon } from '../controls/icons.js';
import { frameCount, isZoomed, lastFrame } from './draw/scale.js';
import {
  frame, goTo, hold, isKey, keyBeside, keyFrames, middle, next, nextProblem, step, toFirst,
  togglePlaying, toKey, toLast,
} from './edit/head.js';
import { drawZoomHint, foldLanes, zoomToInterval } from './edit/zoom.js';
import { deleteKey, setKey } from './edit/keying.js';

/** A square button: icon, what it does, its key. */
function button(name, words, key, act, { off = false, pressed = null } = {}) {
  return html`<button class="ib" aria-label=${words} aria-keyshortcuts=${key || nothing}
    title=${key ? `${words}   ${key}` : words} ?disabled=${off} @click=${act}
    aria-pressed=${pressed === null ? nothing : String(pressed)}>${icon(name)}</button>`;
}

export function drawBar() {
  if (!server.file) return nothing;
  return html`${transport()}${drawSuggestion()}<span class="sp"></span>${counts()}${drawZoomHint()}${right()}`;
}

function transport() {
  const at = frame();
  const key = isKey(at);
  const end = lastFrame();
  const play = ui.playing ? ['pause', 'Stop'] : ['play', 'Play'];
  return html`
    ${button('first', 'First frame', 'Home', toFirst, { off: at === 0 })}
    ${button('pk', 'Previous keyframe', ',', () => toKey(-1), { off: keyBeside(-1) === undefined })}
    ${button('sb', 'Back one frame', '←', () => step(-1), { off: at === 0 })}
    ${button(...play, 'Space', togglePlaying, { off: end === 0 })}
    ${button('sf', 'Forward one frame', '→', () => step(1), { off: at === end })}
    ${button('nk', 'Next keyframe', '.', () => toKey(1), { off: keyBeside(1) === undefined })}
    ${button('last', 'Last frame', 'End', toLast, { off: at === end })}
    ${frameBox()}
    ${key
      ? button('key', 'Delete keyframe', 'Delete', () => deleteKey(), { pressed: true })
      : button('key', 'Add keyframe', 'K', setKey, { pressed: false })}
    ${keyFrames().length > 0 ? button('mid', 'Middle of this interval', '/', middle) : nothing}
    <span class="vsep"></span>`;
}

const trackChanged = () => send({ do: 'track', what: 'changed' });

const SUGGESTION_ICONS = { good: 'check', track: 'track', look: 'warn' };

/** What helps most now: bold what to do, then why, then a button that does it. While it is being
 * done, how far it is. */
function drawSuggestion() {
  const suggest = server.suggest;
  if (!suggest?.words) return nothing;
  const { state, title, words } = server.job ?? {};
  const atWork = suggest.kind === 'track' && state === 'running';
  const [what, why] = atWork ? [`${title}.`, words] : whatAndWhy(suggest);
  return html`<div class=${`sug ${suggest.kind}`} role="status" title=${`${what} ${why}`}>
    ${icon(SUGGESTION_ICONS[suggest.kind] ?? 'keyadd')}
    <span class="tx"><b>${what}</b> <span class="mut">${why}</span></span>
    ${atWork ? html`<span class="pad"></span>` : suggestionButton(suggest)}</div>`;
}

/** The first sentence is what to do; the others, and the reason, are why. */
function whatAndWhy({ words, reason }) {
  const end = words.search(/[.:] /);
  const what = end < 0 ? words : words.slice(0, end + 1);
  const more = end < 0 ? '' : `${words.slice(end + 2)} `;
  return [what, more + (reason && !reason.endsWith('.') ? `${reason}.` : reason ?? '')];
}

function suggestionButton({ frame: to, kind }) {
  const labelled = (label, key, words, act) => html`<button class="btn sm pri" aria-label=${words}
    @click=${act}>${label}<kbd>${key}</kbd></button>`;
  if (kind === 'track') {
    const { verb } = subject();
    return labelled(verb, 'T', `${verb} changed segments`, trackChanged);
  }
  if (to === null || to === undefined || to === frame()) return html`<span class="pad"></span>`;
  return labelled('Go', 'N', `Go to frame ${to}`, next);
}

const SIGNS = [['good', 'check'], ['check', 'warn'], ['lost', 'lost']];

/** How many segments are good, to check and lost; a press goes to the next of them. */
function counts() {
  const states = (server.segments ?? []).map((segment) => segment.state);
  const told = SIGNS.map(([state, sign]) => [states.filter((s) => s === state).length, state, sign]);
  if (told.every(([count]) => count === 0)) return nothing;
  return html`<span class="counts">${told.map((each) => drawCount(...each))}</span>`;
}

function drawCount(count, state, sign) {
  if (count === 0) return nothing;
  const said = state === 'check' ? 'to check' : state;
  const inside = html`${icon(sign)}${count}<span class="word"> ${said}</span>`;
  const words = `${count} ${said}`;
  if (state === 'good') return html`<span class="count good" title=${words}>${inside}</span>`;
  return html`<button class=${`count ${state}`} aria-label=${`${words}, go to the next`}
    title=${`Go to the next ${state === 'check' ? 'one to check' : 'lost one'}   Shift N`}
    @click=${() => nextProblem(state)}>${inside}</button>`;
}

function right() {
  if ((server.segments ?? []).length === 0 || frameCount() < 2) return nothing;
  const choice = (name, label, title) => html`<button title=${title}
    aria-pressed=${String(ui.chart === name)} @click=${() => setUi('chart', name)}>${label}</button>`;
  const fold = ui.lanes ? 'Fold the lanes' : 'Show all lanes';
  const charts = html`<div class="seg" role="group" aria-label="Chart">
      ${choice('angle', 'Angle', 'Angle of the selected part')}
      ${choice('score', 'Score', 'Error per pass of this segment')}</div>`;
  return html`${isSurface() ? nothing : charts}
    <span class=${`fold${ui.lanes ? '' : ' folded'}`}>${button('chev', fold, 'I', foldLanes)}</span>
    ${button('grow', 'Zoom to this interval', 'Z', zoomToInterval, { pressed: isZoomed() || null })}`;
}

function frameBox() {
  const digits = String(lastFrame()).length;
  return html`<label class="fbox" title="Type a frame, or +5 and -5">
    ${icon('film', 'width:14px;color:var(--t3)')}
    <input aria-label="Frame" inputmode="numeric" autocomplete="off" spellcheck="false"
      style=${`width:${Math.max(2, digits)}ch`} @focus=${(event) => event.target.select()}
      @keydown=${typed} @blur=${(event) => show(event.target)} />
    <span class="dim">/ ${lastFrame()}</span></label>`;
}

/** Write the playhead's frame into the box; never while someone types in it. */
export function show(input) {
  if (input === null || document.activeElement === input) return;
  input.value = String(frame());
}

function typed(event) {
  const input = event.target;
  event.stopPropagation();
  if (event.key === 'Escape') {
    input.blur();
  } else if (event.key === 'Enter') {
    const to = meant(input.value.trim());
    hold();
    if (to !== null) goTo(to);
    input.blur();
  } else if (event.key === 'ArrowUp' || event.key === 'ArrowDown') {
    event.preventDefault();
    goTo(frame() + (event.key === 'ArrowUp' ? 1 : -1));
    input.value = String(frame());
    input.select();
  }
}

function meant(text) {
  if (!/^[+\-−]?\d+$/.test(text)) return null;
  const number = Number(text.replace('−', '-'));
  return /^\d/.test(text) ? number : frame() + number;
}
