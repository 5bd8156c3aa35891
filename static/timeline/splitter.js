// The line between stage and timeline: drag it, or step it with the arrow keys; a double click
// gives the height of the house back. The height is kept in this browser.

import { html } from '../vendor/lit-html/lit-html.js';
import { pull } from '../controls/gesture.js';
import { inBrowser } from '../store/storage.js';

const KEPT = 'keypose.timeline.height';
const LEAST_PX = 120;
const MOST_SHARE = 0.5;
const STEP_PX = 16;

const root = document.documentElement;
let section = null;

export function mountSplitter(time) {
  section = time;
  const kept = Number(inBrowser.read(KEPT));
  if (kept > 0) setHeight(kept);
  // In a lower window the kept height may be more than half of it.
  window.addEventListener('resize', () => isSet() && setHeight(section.offsetHeight));
}

function isSet() {
  return root.style.getPropertyValue('--h-time') !== '';
}

function most() {
  return Math.round(window.innerHeight * MOST_SHARE);
}

function setHeight(px) {
  const height = Math.max(LEAST_PX, Math.min(most(), Math.round(px)));
  root.style.setProperty('--h-time', `${height}px`);
}

function keep() {
  inBrowser.write(KEPT, section.offsetHeight);
}

function restore() {
  root.style.removeProperty('--h-time');
  inBrowser.remove(KEPT);
}

export function splitter() {
  return html`<div class="tsplit" role="separator" aria-orientation="horizontal" tabindex="0"
    aria-label="Height of the timeline" title="Drag to resize, double-click to restore"
    @pointerdown=${grab} @dblclick=${restore} @keydown=${keys}
    @mousedown=${(event) => event.preventDefault()}></div>`;
}

function grab(event) {
  if (event.button !== 0) return;
  const offset = section.getBoundingClientRect().top - event.clientY;
  const move = (e) => setHeight(section.getBoundingClientRect().bottom - e.clientY - offset);
  pull(event.currentTarget, event, { move, end: () => isSet() && keep() });
}

function keys(event) {
  const by = { ArrowUp: STEP_PX, ArrowDown: -STEP_PX }[event.key];
  if (by === undefined) return;
  event.preventDefault();
  event.stopPropagation();
  setHeight(section.offsetHeight + by);
  keep();
}
