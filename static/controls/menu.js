// Menus: one hangs from a button, another stands at the pointer, by typing one finds an entry. One is
// open at a time; a choice, a press elsewhere, Esc and a window that loses the focus close it.
// Entries: { icon, label, right, run, off: why not, title, checked, kind: a class of its own } { icon,
// label, run(frame), ask: { value, last, answer } }  asks for a frame: Enter or the button `answer`
// acts and `line`, `heading`, `note`, `content`

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { setUi, ui } from '../store/state.js';
import { clamp } from './arithmetic.js';
import { addOnTop, reachedByKey } from './focus.js';
import { icon } from './icons.js';

const MARGIN = 8;

/**
 * The top of something so high: below, or above where the window has no room below.
 * @param {number} height
 * @param {number} below
 * @param {number} above
 * @param {number} [margin]
 */
export function belowOrAbove(height, below, above, margin = MARGIN) {
  return below + height > innerHeight - margin ? above - height : below;
}

/**
 * Put an element of `position: fixed` at this place, as far as the window is wide enough for it.
 * @param {HTMLElement} element
 * @param {number} left
 * @param {number} top
 */
export function standAt(element, left, top) {
  const { width } = element.getBoundingClientRect();
  element.style.left = `${clamp(left, MARGIN, innerWidth - width - MARGIN)}px`;
  element.style.top = `${top}px`;
}

const PAUSE_MS = 700;

/** What was typedLetters until now, and when last. */
let typedLetters = '';
let last = -Infinity;

/** Another menu has opened: what was typedLetters in the one before does not count. */
export function beginTyping() {
  last = -Infinity;
}

/**
 * The entry that is meant by one more letter, or -1.
 * @param {string[]} labels
 * @param {number} at  The entry that has the focus, or -1.
 * @param {string} letter
 * @param {number} now  Milliseconds.
 */
export function typedTo(labels, at, letter, now) {
  const goesOn = now - last < PAUSE_MS;
  last = now;
  const whole = (goesOn ? typedLetters : '') + letter.toLowerCase();
  const to = meant(labels, at, whole);
  // What no entry begins with is a new word.
  typedLetters = to < 0 ? letter.toLowerCase() : whole;
  return to < 0 && goesOn ? meant(labels, at, typedLetters) : to;
}

function meant(labels, at, wanted) {
  // The same letter again and again goes through all that begin with it.
  const isOne = [...wanted].every((each) => each === wanted[0]);
  const begins = isOne ? wanted[0] : wanted;
  const start = isOne ? at + 1 : Math.max(at, 0);
  const order = labels.map((_, i) => (start + i) % labels.length);
  return order.find((i) => labels[i].toLowerCase().startsWith(begins)) ?? -1;
}

const LEAST_TOP = 8;

export const line = { line: true };
export const heading = (words) => ({ heading: words });
export const note = (content) => ({ note: content });
export const content = (template) => ({ content: template });

/** Where the menu at the pointer is drawn, and what had the focus before it. */
let place = null;
let before = null;
/** Whether a key was the last thing that was pressed: then the first entry has the focus at once. */
let byKeys = false;

export function mountMenus() {
  place = addOnTop('tmenu', 'div'); // on the start screen, too, where the timeline is out of reach
  place.setAttribute('role', 'region');
  place.setAttribute('aria-label', 'Menu');
  addEventListener('pointerdown', closeFromOutside, true);
  addEventListener('pointerdown', () => (byKeys = false), true);
  addEventListener('keydown', () => (byKeys = true), true);
  addEventListener('blur', () => closeMenu());
  addEventListener('resize', () => closeAtPointer());
}

/** Close what is open; returns whether anything was. */
export function closeMenu() {
  return closeAtPointer() || closeHanging();
}

function closeFromOutside({ target }) {
  if (ui.menu && !holder(ui.menu)?.contains(target)) closeHanging();
  if (!place?.contains(target)) closeAtPointer();
}

// --- hanging from a button

/**
 * A button that opens its menu.
 * @param {string} name
 * @param {{ title: string, kind: string, face: unknown, label?: string, act?: () => void }} spec
 */
export function menuButton(name, { title, kind, face, label, act = () => toggleMenu(name) }) {
  return html`<button class="${kind} ${ui.menu === name ? 'hov' : ''}" title=${title || nothing}
    aria-label=${label ?? nothing}
    aria-haspopup="menu" aria-expanded=${ui.menu === name} @click=${act}>${face}</button>`;
}

/**
 * A button, or several, with a menu below: button: (whether it is open) → template; items: () → entries.
 */
export function menuHolder(name, button, items, side = 'left') {
  const open = ui.menu === name;
  return html`<span class="holder" data-menu=${name}>
    ${button(open)}${
      open
        ? html`<div class="menu ${side}" role="menu" tabindex="-1" @keydown=${onKey}>${rows(items())}</div>`
        : nothing
    }
  </span>`;
}

/** Open this menu, or close it when it is the open one. */
export function toggleMenu(name) {
  if (ui.menu === name) {
    closeMenu();
    return;
  }
  setUi('menu', name);
  beginTyping();
  // The menu is drawn with the next frame; only then can it take the keys.
  requestAnimationFrame(() => requestAnimationFrame(focusMenu));
}

function closeHanging() {
  if (!ui.menu) return false;
  const opener = holder(ui.menu)?.querySelector('button');
  setUi('menu', null);
  if (reachedByKey()) opener?.focus();
  return true;
}

function focusMenu() {
  const list = ui.menu && holder(ui.menu)?.querySelector('.menu');
  if (!list) return;
  const target = reachedByKey() || byKeys ? (list.querySelector('.mi.here') ?? list.querySelector('.mi')) : list;
  target?.focus();
  list.querySelector('.mi.here')?.scrollIntoView({ block: 'center' });
}

function holder(name) {
  return document.querySelector(`[data-menu="${name}"]`);
}

// --- at the pointer

/** Open a menu at a place of the window. */
export function openMenuAt(label, entries, [left, top]) {
  beginTyping();
  const active = document.activeElement;
  before = active !== null && active !== document.body ? active : null;
  render(
    html`<div class="menu tmenu" role="menu" aria-label=${label} tabindex="-1"
    @keydown=${onKey} @contextmenu=${(event) => event.preventDefault()}>${rows(entries)}</div>`,
    place,
  );
  const menu = place.firstElementChild;
  const { height } = menu.getBoundingClientRect();
  standAt(menu, left, Math.max(LEAST_TOP, belowOrAbove(height, top, top)));
  (before === null && !byKeys ? menu : choicesOf(menu)[0])?.focus({ preventScroll: true });
}

function closeAtPointer() {
  if (!place?.firstElementChild) return false;
  render(nothing, place);
  before?.focus?.({ preventScroll: true });
  before = null;
  return true;
}

// --- what is in them

const rows = (entries) => entries.filter(Boolean).map(row);

function row(entry) {
  if (entry.line) return html`<hr />`;
  if (entry.heading) return html`<div class="mh">${entry.heading}</div>`;
  if (entry.note) return html`<div class="mn">${entry.note}</div>`;
  if (entry.content) return entry.content;
  return entry.ask ? question(entry) : choice(entry);
}

function choice(item) {
  const role = item.checked === undefined ? 'menuitem' : 'menuitemradio';
  return html`<button
    class="row mi ${item.kind ?? ''}"
    role=${role}
    tabindex="-1"
    aria-checked=${item.checked ?? nothing}
    aria-disabled=${item.off ? 'true' : nothing}
    title=${item.off || item.title || nothing}
    @click=${() => choose(item)}
  >
    ${item.icon ? icon(item.icon) : nothing}<span class="ml">${item.label}</span>
    ${item.right ? html`<span class="r">${item.right}</span>` : nothing}
  </button>`;
}

function choose(item) {
  if (item.off) return;
  closeMenu();
  item.run();
}

function question({ icon: sign, label, ask, run }) {
  const answer = (event) => {
    const input = event.currentTarget.closest('.mi').querySelector('input');
    const frame = Number(input.value);
    if (input.value.trim() === '' || !Number.isInteger(frame) || frame < 0 || frame > ask.last) {
      input.setAttribute('aria-invalid', 'true');
      return;
    }
    closeMenu();
    run(frame);
  };
  return html`<div class="row mi asks">${icon(sign)}<label for="tmenu-frame">${label}</label>
    <input id="tmenu-frame" inputmode="numeric" autocomplete="off" .value=${String(ask.value)}
      @input=${(event) => event.target.removeAttribute('aria-invalid')} />
    <button class="btn sm" @click=${answer}>${ask.answer}</button></div>`;
}

// --- keys

/** @returns {HTMLElement[]} */
const choicesOf = (menu) => [...menu.querySelectorAll('button.mi, .asks input')];

function onKey(event) {
  const { currentTarget: menu, target, key } = event;
  const choices = choicesOf(menu);
  const at = choices.indexOf(/** @type {HTMLElement} */ (document.activeElement));
  const isText = target.matches('input');
  const to = {
    ArrowDown: (at + 1) % choices.length,
    ArrowUp: (at + choices.length - (at < 0 ? 0 : 1)) % choices.length,
    ...(isText ? {} : { Home: 0, End: choices.length - 1, ...typed(event, choices, at) }),
  }[key];
  const isAnswer = isText && key === 'Enter';
  if (to !== undefined) choices[to].focus();
  else if (isAnswer) target.parentElement.querySelector('.btn').click();
  else if (key === 'Tab') leaveWithTab(event, menu);
  else if (!target.matches('button, input') || (key !== 'Enter' && key !== ' ')) return;
  event.stopPropagation();
  if (to !== undefined || isAnswer) event.preventDefault();
}

/** Where a letter leads: to the entry that begins with what was typed. */
function typed({ key, ctrlKey, metaKey, altKey, timeStamp }, choices, at) {
  if (ctrlKey || metaKey || altKey || !/^[\p{L}\p{N}]$/u.test(key)) return {};
  const labels = choices.map((each) => each.querySelector('.ml')?.textContent.trim() ?? '');
  const to = typedTo(labels, at, key, timeStamp);
  return to < 0 ? { [key]: Math.max(at, 0) } : { [key]: to };
}

/** From a button Tab goes on to the next one; at the pointer it goes back to what had the focus. */
function leaveWithTab(event, menu) {
  if (place?.contains(menu)) event.preventDefault();
  closeMenu();
}
