// The timeline: a bar, and one drawing in layers under it. See drawing.js for what is drawn when.

import { clamp } from '../controls/arithmetic.js';
import { html, render } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi, watch } from '../store/state.js';
import { anyLane, lanesOf } from './marks/lanes.js';
import { bodiesHeight } from './marks/bodies.js';
import { filmsHeight } from './marks/films.js';
import { bottomOf } from './marks/scores.js';
import { followRows, hasCamera, hasPins, watchPointer } from './more_rows.js';
import { drawBar, show } from './bar.js';
import { areFolded, isZoomed, mountFold, reveal } from '../actions/window.js';
import { noticeZoom, showOpened } from './opening.js';
import { frame } from '../actions/playhead.js';
import { listenOn } from './gestures.js';
import { grabbed } from './pointer.js';
import { mountPlaying } from '../actions/playing.js';
import { mountSelection } from '../actions/selection.js';
import { listenForPinKeys } from './marks/pins.js';
import { mountNoteCard } from './note_card.js';
import { mountAngleCard } from './angle_card.js';
import { mountReduceCard } from './reduce_card.js';
import { clearNumbers, PATTERNS } from './draw/ground.js';
import { GUTTER, isCramped, rowsFor, setWidth } from './draw/scale.js';
import { flagWidth } from './draw/playhead.js';
import { layersOf } from './drawing.js';
import { memoize } from './draw/series.js';

/** @type {import('../store/shapes.js').Watched[]} */
const WATCHED = [
  'file',
  'damage',
  'view',
  'keys',
  'segments',
  'draft',
  'reduction',
  'suggest',
  'need',
  'lanes',
  'curve',
  'body',
  'job',
  'pins',
  'proposed_pins',
  'camera_motion',
  'bodies',
  'bonds',
  'films',
  'films_seen',
  'notes',
  'u:timePin',
  'review',
  'u:review',
  'u:placeSeen',
  'u:reviewGoal',
  'u:reviewLeft',
  'u:timeKeys',
  'u:span',
  'u:loop',
  'u:speed',
  'u:shuttle',
  'u:playing',
  'u:chart',
  'u:lanes',
  'u:curveAxis',
  'u:timeWindow',
  'u:timeSize',
  'u:timeHead',
  'u:timeGrabbed',
  'u:timeHover',
  'u:timeOpen',
  'u:timeScroll',
  'u:zoomHint',
];

ui.timeSize = { width: 0, height: 0 };
/** Groups of lanes whose parts are listed. */
ui.timeOpen = new Set();
ui.timeScroll = 0;

export function mount() {
  const time = document.getElementById('time');
  render(frameOf(), time);
  const drawing = time.querySelector('#tsvg');
  mountFold();
  listenOn(drawing, ground, scrollLanes);
  watchPointer();
  listenForPinKeys();
  mountNoteCard(time.querySelector('#tnote'), drawing);
  mountReduceCard(time.querySelector('#treduce'), drawing);
  mountAngleCard(time.querySelector('#tangle'), drawing);
  mountSelection();
  mountPlaying();
  const bar = time.querySelector('#tr');
  const drawLayers = layersOf(drawing);
  new ResizeObserver(() => measure(drawing)).observe(drawing);
  measure(drawing);
  watch(WATCHED, () => redraw(bar, drawing, drawLayers));
}

function frameOf() {
  return html`<div id="tr" class="row" role="toolbar" aria-label="Frames" @mousedown=${keepFocus}></div>
    <svg id="tsvg" role="group" aria-label="Frames, keyframes and segments">${PATTERNS}
      <clipPath id="tl-frames"><rect x=${GUTTER + 1} y="-4" width="100000" height="10000" /></clipPath>
    </svg>
    <div id="tnote"></div><div id="treduce"></div><div id="tangle"></div>`;
}

/** A press on the bar leaves the focus where keys reach the views; the frame box is typed into. */
function keepFocus(event) {
  if (event.target.closest('.fbox')) return;
  event.preventDefault();
  document.activeElement?.blur?.();
}

function measure(drawing) {
  const { clientWidth: width, clientHeight: height } = drawing;
  if (width === ui.timeSize.width && height === ui.timeSize.height) return;
  setWidth(width);
  setUi('timeSize', { width, height });
}

const rows = memoize((height, zoomed, lanes, weakest, pins, camera, bodies, films) =>
  rowsFor({ height, zoomed, lanes, weakest, pins, camera, bodies, films }),
);

/** @returns {import('./mark.js').Stage} */
function ground() {
  const folded = areFolded() || isCramped(ui.timeSize.height);
  const lanes = lanesOf(server.lanes, server.body, folded, ui.timeOpen);
  const own = [hasPins(), hasCamera(), bodiesHeight(), filmsHeight()];
  const box = rows(ui.timeSize.height, isZoomed(), lanes.length, folded, ...own);
  const most = Math.max(0, box.lanes.full - box.lanes.room);
  // Whole lanes: a wheel of fine steps adds up until the next one comes.
  const scroll = Math.round(Math.min(ui.timeScroll, most) / box.lanes.each) * box.lanes.each;
  return { rows: box, lanes, scroll, empty: !anyLane(server.lanes), bottom: bottomOf(box) };
}

function scrollLanes(by) {
  const { full, room } = ground().rows.lanes;
  setUi('timeScroll', clamp(ui.timeScroll + by, 0, Math.max(0, full - room)));
}

let before = { clip: null, frame: null };

function redraw(bar, drawing, drawLayers) {
  follow();
  followRows();
  noticeZoom();
  render(drawBar(), bar);
  show(bar.querySelector('.fbox input'));
  drawLayers(ground());
  const head = drawing.querySelector('.playhead');
  if (head) clearNumbers(drawing, frame(), flagWidth());
}

/** Another clip is shown whole; a playhead that leaves the window takes it along. */
function follow() {
  const clip = server.file ? `${server.file.path} ${server.file.frames}` : null;
  if (clip !== before.clip) showOpened();
  else if (frame() !== before.frame) reveal(frame(), pageFor());
  before = { clip, frame: frame() };
}

/** Playing turns whole pages; a hand on the playhead pulls the window along with it. */
function pageFor() {
  if (ui.playing) return 0.9;
  return grabbed() === null ? 0.1 : 0;
}
