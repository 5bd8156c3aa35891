// Which view stands where, how large, and the lines between the page's parts that are dragged to size
// them. Views change places by style alone: an iframe that is moved in the document loads anew.

import { clamp } from '../controls/arithmetic.js';
import { largeFilm } from '../store/films.js';
import { setUi, ui, watch } from '../store/state.js';
import { pull } from '../controls/gesture.js';
import { inBrowser } from '../store/storage.js';

const SMALL_PLACES = ['one', 'two', 'three'];
const SMALL_VIEWS = ['top', 'side', 'front'];
const LEAST_MAIN_PX = 560;
const KEPT = 'keypose-sizes';
const STEP_PX = 16;

/** What can be dragged: where it is, what it sizes, the style it sets, its range, and which way makes it larger. */
const SPLITTERS = {
  views: { in: 'stage', label: 'Width of the views', style: '--w-views', least: 176, most: 420, along: 'x', grows: -1 },
  insp: {
    in: 'insp',
    label: 'Width of the inspector',
    style: '--w-insp',
    least: 256,
    most: 400,
    along: 'x',
    grows: -1,
  },
  time: {
    in: 'time',
    label: 'Height of the timeline',
    style: '--h-time',
    least: 120,
    most: () => innerHeight / 2,
    along: 'y',
    grows: -1,
  },
  first: { in: 'stage', label: 'Height of the view above', style: '--r-one', least: 80, along: 'y', grows: 1, rows: 0 },
  second: {
    in: 'stage',
    label: 'Height of the view above',
    style: '--r-two',
    least: 80,
    along: 'y',
    grows: 1,
    rows: 1,
  },
};

export function mountLayout() {
  for (const name of Object.keys(SPLITTERS)) document.getElementById(SPLITTERS[name].in).append(splitter(name));
  restore();
  watch(['films', 'u:filmLarge', 'u:layout'], place);
  // In a lower window a chosen height may be more than half of it.
  addEventListener(
    'resize',
    () => document.documentElement.style.getPropertyValue('--h-time') && set('time', sizeOf('time')),
  );
}

let before = 'main';

/** Put this view in the large place, or "quad"; the same again goes back to what was before. */
export function showLarge(name) {
  const now = ui.layout;
  setUi('layout', now === name ? before : name);
  before = now;
}

function place() {
  const stage = document.getElementById('stage');
  stage.dataset.layout = ui.layout;
  stage.toggleAttribute('data-film', largeFilm() !== null);
  const large = [...SMALL_VIEWS, 'free'].includes(ui.layout) ? ui.layout : 'main';
  const replaced = large === 'free' ? 'top' : large;
  /** @type {NodeListOf<HTMLElement>} */
  const views = document.querySelectorAll('.view');
  for (const view of views) {
    const { view: name } = view.dataset;
    if (name === 'film') continue;
    // The camera goes where the enlarged view came from.
    const home = SMALL_VIEWS.indexOf(name === 'main' ? replaced : name);
    view.style.gridArea = name === large ? 'large' : SMALL_PLACES[home];
    view.classList.toggle('large', name === large);
  }
}

function splitter(name) {
  const element = document.createElement('div');
  element.className = 'splitter';
  element.dataset.split = name;
  element.tabIndex = 0;
  element.role = 'separator';
  element.ariaOrientation = SPLITTERS[name].along === 'x' ? 'vertical' : 'horizontal';
  element.ariaLabel = SPLITTERS[name].label;
  element.title = 'Drag to resize, double-click to restore';
  element.addEventListener('focus', () => describeSize(element, name));
  describeSize(element, name);
  element.addEventListener('pointerdown', (event) => drag(event, name));
  element.addEventListener('dblclick', () => set(name, null));
  element.addEventListener('keydown', (event) => nudge(event, name));
  return element;
}

/** For a screen reader. */
function describeSize(element, name) {
  const { least, most, rows } = SPLITTERS[name];
  const largest = rows === undefined ? (typeof most === 'function' ? most() : most) : innerHeight;
  element.ariaValueMin = String(least);
  element.ariaValueMax = String(Math.round(largest));
  element.ariaValueNow = String(element.isConnected ? Math.round(sizeOf(name)) : least);
}

function drag(event, name) {
  if (event.button !== 0) return;
  const { currentTarget: element } = event;
  const { along, grows } = SPLITTERS[name];
  const from = along === 'x' ? event.clientX : event.clientY;
  const size = sizeOf(name);
  const move = ({ clientX, clientY }) => {
    const to = along === 'x' ? clientX : clientY;
    set(name, size + grows * (to - from));
  };
  pull(element, event, { move, end: keep });
}

function nudge(event, name) {
  const { along, grows } = SPLITTERS[name];
  const keys = along === 'x' ? ['ArrowLeft', 'ArrowRight'] : ['ArrowUp', 'ArrowDown'];
  const way = keys.indexOf(event.key);
  if (way < 0) return;
  event.preventDefault();
  event.stopPropagation();
  set(name, sizeOf(name) + grows * (way === 0 ? -STEP_PX : STEP_PX));
  keep();
  describeSize(event.currentTarget, name);
}

/** What the chart of a joint's angle and the rows of bodies and films add to the timeline meanwhile, px. */
function addedHeight() {
  const style = getComputedStyle(document.documentElement);
  const px = (name) => parseFloat(style.getPropertyValue(name)) || 0;
  return px('--h-chart') + px('--h-more');
}

/** The size now, in pixels. */
function sizeOf(name) {
  const { rows } = SPLITTERS[name];
  if (rows !== undefined) return rowHeights()[rows];
  const ids = { views: null, insp: 'insp', time: 'time' };
  const element = ids[name] ? document.getElementById(ids[name]) : smallView();
  return SPLITTERS[name].along === 'x'
    ? element.offsetWidth
    : element.offsetHeight - (name === 'time' ? addedHeight() : 0);
}

/** @returns {HTMLElement} */
function smallView() {
  return document.querySelector('.view:not(.large)');
}

function rowHeights() {
  const stage = document.getElementById('stage');
  return getComputedStyle(stage).gridTemplateRows.split(' ').map(parseFloat);
}

/** Set a size, or with null go back to the usual one. */
function set(name, size) {
  const { style, least, most, rows } = SPLITTERS[name];
  const root = document.documentElement.style;
  if (size === null) {
    root.removeProperty(style);
    if (rows !== undefined) for (const each of ['--r-one', '--r-two', '--r-three']) root.removeProperty(each);
    keep();
    return;
  }
  if (rows !== undefined) return resizeViewRow(rows, size, least);
  let largest = typeof most === 'function' ? most() : most;
  /** @type {HTMLElement} */
  const large = document.querySelector('.view.large');
  if (name !== 'time') largest = Math.min(largest, sizeOf(name) + large.offsetWidth - LEAST_MAIN_PX);
  root.setProperty(style, `${Math.round(clamp(size, least, largest))}px`);
}

/** Two neighbouring rows share what they have. */
function resizeViewRow(row, size, least) {
  const heights = rowHeights();
  const both = heights[row] + heights[row + 1];
  heights[row] = clamp(size, least, both - least);
  heights[row + 1] = both - heights[row];
  const root = document.documentElement.style;
  ['--r-one', '--r-two', '--r-three'].forEach((name, i) => root.setProperty(name, `${heights[i]}fr`));
}

function keep() {
  const root = document.documentElement.style;
  const names = ['--w-views', '--w-insp', '--h-time', '--r-one', '--r-two', '--r-three'];
  const sizes = Object.fromEntries(names.map((name) => [name, root.getPropertyValue(name)]));
  inBrowser.write(KEPT, JSON.stringify(sizes));
}

function restore() {
  try {
    const sizes = JSON.parse(inBrowser.read(KEPT) ?? '{}');
    for (const [name, size] of Object.entries(sizes)) {
      if (/^[\d.]+(px|fr)$/.test(size)) document.documentElement.style.setProperty(name, size);
    }
  } catch {
    // Unreadable sizes are the usual ones.
  }
}
