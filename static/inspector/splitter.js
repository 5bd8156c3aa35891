// The line between the views and the inspector: dragged, it makes one wider and the other narrower.

import { pull } from '../controls/gesture.js';
import { inBrowser } from '../store/storage.js';

const LEAST = 256;
const MOST = 400;
const STEP = 16;
const KEY = 'keypose.inspector.width';

/** Put the splitter on the inspector's left edge, at the width this browser had last. */
export function addSplitter(inspector) {
  const bar = document.createElement('div');
  bar.className = 'insp-split';
  bar.tabIndex = 0;
  bar.title = 'Drag to resize, double-click for the usual width';
  for (const [name, value] of Object.entries({
    role: 'separator', 'aria-orientation': 'vertical', 'aria-label': 'Width of the inspector',
    'aria-valuemin': LEAST, 'aria-valuemax': MOST,
  })) bar.setAttribute(name, String(value));
  inspector.append(bar);
  const resize = (width) => setWidth(bar, width);
  bar.addEventListener('pointerdown', (event) => grab(event, bar, inspector, resize));
  bar.addEventListener('dblclick', () => resize(null));
  bar.addEventListener('keydown', (event) => nudge(event, inspector, resize));
  resize(kept());
}

function grab(down, bar, inspector, resize) {
  if (down.button !== 0) return;
  down.preventDefault();
  const from = inspector.getBoundingClientRect().width;
  bar.classList.add('held');
  pull(bar, down, {
    move: (event) => resize(from + down.clientX - event.clientX),
    end: () => bar.classList.remove('held'),
  });
}

function nudge(event, inspector, resize) {
  const way = { ArrowLeft: 1, ArrowRight: -1 }[event.key];
  if (way === undefined) return;
  event.preventDefault();
  event.stopPropagation();
  resize(inspector.getBoundingClientRect().width + way * STEP);
}

/** null: the usual width, which depends on the window. */
function setWidth(bar, width) {
  const root = document.documentElement.style;
  if (width === null) root.removeProperty('--w-insp');
  else root.setProperty('--w-insp', `${Math.round(Math.min(MOST, Math.max(LEAST, width)))}px`);
  const now = getComputedStyle(document.documentElement).getPropertyValue('--w-insp');
  bar.setAttribute('aria-valuenow', parseInt(now, 10));
  keep(width === null ? null : root.getPropertyValue('--w-insp'));
}

function kept() {
  const width = parseFloat(inBrowser.read(KEY));
  return Number.isFinite(width) ? width : null;
}

function keep(width) {
  if (width === null) inBrowser.remove(KEY);
  else inBrowser.write(KEY, width);
}
