// Nothing moves under a pressed pointer, and what comes under a resting one by itself is not pressed by
// mistake. While a control is pressed, news that would add, remove or move controls waits
// (store/state.js), and so do messages. While a picture is pressed, what floats over it lets the pointer
// through: by `data-pressed` of the page, and the sheets.

import { hold, onRedraw, release } from '../store/state.js';

/** Where a press is a gesture of its own, or shows something while it lasts: it needs the newest of everything. */
const PICTURES = '.view > .over';
const GESTURES = `${PICTURES}, #tsvg, [data-while-held]`;
const CONTROLS = 'button, input, label, [role="slider"], [role="option"], [tabindex]';
/** So long a control that came under the resting pointer takes no press. */
const NEW_MS = 400;
/** What comes so soon after a press or a key is its answer. */
const ANSWER_MS = 1000;

/** @type {Element | null} */
let pressed = null;
let holds = false;
/** What waits to be drawn until the pointer is released. @type {Set<() => void>} */
const late = new Set();

export function mountSteady() {
  addEventListener('pointerdown', down, true);
  for (const kind of ['pointerup', 'pointercancel', 'blur']) addEventListener(kind, letGoSoon, true);
  addEventListener('pointermove', moved, { capture: true, passive: true });
  addEventListener('keydown', () => (acted = performance.now()), true);
  addEventListener('click', swallowClick, true);
  onRedraw(look);
}

/** The same, but not while a control is pressed: then once it is released. @param {() => void} draw */
export const steadily = (draw) => () => {
  if (holds) late.add(draw);
  else draw();
};

/** Whether a control is pressed: nothing goes on by itself meanwhile. */
export const isHeld = () => holds;

/** @param {PointerEvent} event */
function down(event) {
  if (!event.isPrimary) return;
  swallows = isNew(event);
  acted = performance.now();
  if (swallows) {
    event.preventDefault();
    event.stopImmediatePropagation();
    return;
  }
  pressed = event.target instanceof Element ? event.target : document.documentElement;
  if (pressed.closest(PICTURES)) document.documentElement.dataset.pressed = 'picture';
  if (pressed.closest(GESTURES)) return;
  holds = true;
  hold();
}

/** Only after the click, which still means what was to be seen. */
function letGoSoon() {
  if (pressed !== null) setTimeout(letGo);
}

function letGo() {
  pressed = null;
  holds = false;
  acted = performance.now();
  delete document.documentElement.dataset.pressed;
  release();
  for (const draw of late) draw();
  late.clear();
}

// --- what comes under the pointer while it rests

/** @type {{ x: number, y: number } | null} */
let rests = null;
/** What would be pressed there, and since when. */
let under = '';
let since = -Infinity;
let acted = -Infinity;
let swallows = false;

/** @param {PointerEvent} event */
function moved({ clientX: x, clientY: y, buttons, pointerType, target }) {
  // A release outside of the window may never be heard of.
  if (buttons === 0) letGoSoon();
  rests = pointerType === 'mouse' ? { x, y } : null;
  under = nameOf(target);
  since = -Infinity;
}

function look() {
  if (rests === null || pressed !== null) return;
  const now = nameOf(document.elementFromPoint(rests.x, rests.y));
  if (now === under) return;
  under = now;
  const isAnswer = performance.now() - acted < ANSWER_MS;
  since = isAnswer ? -Infinity : performance.now();
}

/** @param {PointerEvent} event */
function isNew({ clientX, clientY, target }) {
  const isThere = rests !== null && Math.hypot(clientX - rests.x, clientY - rests.y) < 2;
  const isSoon = performance.now() - since < NEW_MS && performance.now() - acted > ANSWER_MS;
  return isThere && isSoon && nameOf(target) !== '';
}

/** Which control it is, whatever number it shows. @param {EventTarget | null} target */
function nameOf(target) {
  const control = target instanceof Element ? target.closest(CONTROLS) : null;
  if (!control) return '';
  const words = control.getAttribute('data-action') ?? control.getAttribute('aria-label') ?? control.textContent ?? '';
  return `${control.tagName} ${words.replace(/\d+/g, '')}`;
}

/** @param {MouseEvent} event */
function swallowClick(event) {
  if (!swallows) return;
  swallows = false;
  event.preventDefault();
  event.stopImmediatePropagation();
}
