// The glass bars over the large view: its head, its feet, drafts and notes. They move with it when
// another view is enlarged.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { keyOf, labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { actionButton } from '../actions/buttons.js';
import {
  boxFrameFor,
  draftedWords,
  nobodyWords,
  personWords,
  placesWords,
  restCount,
  smallWords,
} from '../actions/drafting.js';
import { noteAt, noteAsOneLine } from '../actions/keying.js';
import { partKeyAt } from '../actions/parts.js';
import { bodies, posedBody } from '../store/bodies.js';
import { placesToConfirm } from '../actions/playhead.js';
import { beyondKeys, noMotionYet, segmentsHere } from '../actions/tracking.js';
import { button, iconButton } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { range, roughError, VERDICTS } from '../controls/words.js';
import { damageAt, damageWords, words as subject } from '../store/clip.js';
import { partNamed } from '../store/parts.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { onViews, view as viewNamed, VIEW_KEYS, VIEW_NAMES } from '../views/views.js';
import { drawBoxAt } from './box.js';
import { drawFilmBars, filmCards, mountFilms } from './films.js';
import { isHandleCoveredBy } from './floating.js';
import { displaybar, mountOrbitHint, onSlide, orbitHint, tintbar, toolbar } from './displaybar.js';
import { interaction, onInteraction } from './interaction.js';
import { largeView } from './scale.js';
import { drawingTool } from './sketch.js';

export function headbar() {
  const name = largeView();
  return html`<div class="glass row" id="mhead">
    <span class="row b what name" title="Double-click for the free view"
      @dblclick=${() => setUi('layout', 'free')}><kbd>${VIEW_KEYS[name]}</kbd>${VIEW_NAMES[name]}</span>
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
      <span class="mut say">${
        server.pose.followed ? 'Tracked ahead' : 'Posed'
      }, press <kbd>${keyOf('addKeyframe')}</kbd> to keep</span>`;
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
  return html`<button class="chip old" title=${`${noMotionYet(way)}. ${titleOf(id)}`} data-key=${keyOf(id)}
    @click=${() => perform(id)}>
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
  return {
    say: label ? `${good}${roughError(px, null)} at the ${label}` : short || full,
    why: short || full,
    where: todo,
  };
}

/** Where a click on a chip goes: to the trouble, or to the segment's other end. */
function target({ first, last, go }) {
  if (go != null) return go;
  return server.view.frame === last ? first : last;
}

const ZOOM_STEP = 1.25;
export function footbars() {
  if (ui.layout === 'quad') return sketchLine();
  if (ui.layout === 'free') return [frameBox(), orbitHint()];
  return [frameBox(), zoomBox(), sketchLine()];
}

function frameBox() {
  const { frame } = server.view;
  return html`<div class="glass row" id="mfoot">
    <span class="fr num">${frame}</span>
    <span class="num dim of">of ${server.file.frames - 1}<br />${clock(secondsAt(frame))}</span>
  </div>`;
}

const secondsAt = (frame) => server.file.times?.[frame] ?? frame / server.file.fps;

/** 0:00.83 */
function clock(seconds) {
  const minutes = Math.floor(seconds / 60);
  return `${minutes}:${(seconds - 60 * minutes).toFixed(2).padStart(5, '0')}`;
}

function zoomBox() {
  const view = viewNamed(largeView());
  const { width, height, scale } = view.window;
  const zoom = (factor) => view.zoomAt(width / 2, height / 2, factor);
  const film = view.name === 'main';
  return html`<div class="glass row" id="mzoom">
    <button class="ib s" aria-label="Zoom out" title="Zoom out"
      @click=${() => zoom(1 / ZOOM_STEP)}>${icon('minus')}</button>
    <button class="btn ghost sm num z" title=${film ? 'One to one' : 'Pixels per metre'}
      @click=${() => film && zoom(1 / scale)}>${
        film ? `${Math.round(100 * scale)} %` : `${Math.round(scale)} px/m`
      }</button>
    <button class="ib s" aria-label="Zoom in" title="Zoom in" @click=${() => zoom(ZOOM_STEP)}>${icon('plus')}</button>
    <span class="vsep"></span>
    <button class="btn ghost sm" title=${titleOf('fitView')} data-key=${keyOf('fitView')}
      @click=${() => perform('fitView')}>Fit</button>
  </div>`;
}

/** What to do with the drawing tool in hand. */
function sketchLine() {
  const tool = drawingTool();
  if (!tool) return nothing;
  const isWarning = ui.tool === 'box' && smallWords() !== '';
  const place = ui.tool === 'box' ? 'low' : '';
  if (!tool.words()) return nothing;
  return html`<div class="glass row ${place} ${isWarning ? 'warned' : ''}" id="mhint"
    role="status">${icon(isWarning ? 'warn' : tool.icon)}${tool.words()}${doneButton(tool.done?.())}</div>`;
}

/** @param {{ label: string, key: string, off: string, act: () => void } | null | undefined} done */
const doneButton = (done) => (done ? button({ ...done, kind: done.off ? '' : 'pri' }) : nothing);

export function draftbar() {
  const { draft } = server;
  if (!draft?.latest || ui.draftRead === server.revision || ui.tool === 'box') return nothing;
  const nobody = nobodyWords();
  const person = personWords();
  const at = nobody && boxFrameFor(draft);
  return html`<div class="glass row ${nobody || person ? 'lacking' : ''}" id="mdraft" role="status">
    ${icon(nobody || person ? 'warn' : 'check')}
    <span>${bodies().length > 1 ? `${posedBody()?.name}: ` : ''}${
      nobody ? html`<b>${nobody}</b> ${draftedWords(draft)}` : html`<b>${draftedWords(draft)}</b>`
    } ${person}</span>
    ${restCount() ? actionButton('draftRest', undefined, { name: undefined }) : nothing}
    ${
      nobody
        ? button({
            label: `Draw a box at ${at}`,
            title: 'Draft these frames from a box in one of them',
            act: () => drawBoxAt(at),
          })
        : nothing
    }
    ${
      placesToConfirm().length && !ui.review
        ? actionButton('review', undefined, {
            name: undefined,
            label: `${placesWords()}: review`,
            title: 'Look at them one after another',
          })
        : nothing
    }
    ${actionButton('undo', undefined, {
      name: undefined,
      label: 'Undo draft',
      title: 'Remove the draft',
      kind: 'ghost',
    })}
    ${iconButton({ name: 'x', label: 'Close', act: () => setUi('draftRead', server.revision) })}
  </div>`;
}

export function notebar() {
  const note = noteAt(server.view.frame);
  if (!note || ui.layout === 'quad') return nothing;
  return html`<button class="glass" id="mnote" title=${titleOf('note')} @click=${() => perform('note')}>
    ${icon('note')}<span class="words">${note.text || noteAsOneLine(note)}</span></button>`;
}

/** @type {import('../store/shapes.js').Watched[]} */
const SECTIONS = [
  'file',
  'damage',
  'surface',
  'films',
  'body',
  'view',
  'pose',
  'keys',
  'segments',
  'draft',
  'undo',
  'notes',
];

const host = document.createElement('div');

export function mountBars() {
  host.className = 'bars';
  mountOrbitHint();
  // A bar clicked with the mouse leaves the keys to the views.
  host.addEventListener('mousedown', (event) => event.preventDefault());
  watch(
    [
      ...SECTIONS,
      'u:draftRead',
      'u:tool',
      'u:layout',
      'u:box',
      'people',
      'u:lookedAt',
      'u:guideStep',
      'u:span',
      'u:rings',
      'u:personMask',
      'u:tab',
      'u:menu',
      'u:orbited',
      'u:filmLarge',
      'u:filmHeld',
    ],
    draw,
  );
  mountFilms(draw);
  onViews(draw);
  onInteraction(draw);
  onSlide(draw);
}

function draw() {
  const place = viewNamed(largeView())?.el;
  if (place && host.parentElement !== place) place.append(host);
  host.classList.toggle('quad', ui.layout === 'quad');
  render(server.file && server.view ? bars() : nothing, host);
  drawFilmBars();
  for (const bar of document.querySelectorAll('.bars .glass')) {
    bar.classList.toggle('faded', interaction.drag !== null || (!stays(bar) && isHandleCoveredBy(bar)));
  }
}

/** What a draft found is read while the pointer rests where the box was drawn: at the body. A drawing tool
 * with a button grabs nothing of the body. */
const stays = ({ id }) => id === 'mdraft' || (id === 'mhint' && Boolean(drawingTool()?.done));

function bars() {
  const atTop = [headbar(), toolbar(), displaybar(), tintbar(), damagebar(), draftbar()];
  return html`${atTop}${[notebar(), filmCards(), footbars()]}`;
}

/** What is wrong with the picture, where its frame is damaged. */
function damagebar() {
  const run = damageAt(server.view.frame);
  if (!run) return nothing;
  return html`<div class="glass" id="mdamaged" role="status">${icon('warn')}<span>${damageWords(...run)}</span></div>`;
}
