// A small menu at the pointer: opens upwards where there is no room below, closes on Esc, on a
// press elsewhere, and when the page scrolls or loses the focus.

import { html, render, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from './icons.js';

const MARGIN = 8;
let host = null;
let back = null;

export function mountMenu(element) {
  host = element;
  window.addEventListener('pointerdown', (event) => !host.contains(event.target) && close(), true);
  window.addEventListener('keydown', keys, true);
  window.addEventListener('blur', close);
  window.addEventListener('resize', close);
}

export function isOpen() {
  return host !== null && host.firstElementChild !== null;
}

export function close() {
  if (!isOpen()) return;
  render(nothing, host);
  back?.focus?.({ preventScroll: true });
  back = null;
}

/** Open a menu: `rows` are templates of `item`, `field` and `sentence`. */
export function open(label, rows, [left, top]) {
  const active = document.activeElement;
  back = active !== null && active !== document.body ? active : null;
  render(html`<div class="menu tmenu" role="menu" aria-label=${label} tabindex="-1"
    @contextmenu=${(event) => event.preventDefault()}>${rows}</div>`, host);
  place(host.firstElementChild, left, top);
  (back === null ? host.firstElementChild : choices()[0])?.focus({ preventScroll: true });
}

function place(menu, left, top) {
  const { width, height } = menu.getBoundingClientRect();
  const x = Math.min(left, window.innerWidth - width - MARGIN);
  const y = top + height + MARGIN > window.innerHeight ? top - height : top;
  menu.style.left = `${Math.max(MARGIN, x)}px`;
  menu.style.top = `${Math.max(MARGIN, y)}px`;
}

export function item(name, words, right, act) {
  const run = () => {
    close();
    act();
  };
  return html`<button class="mi" role="menuitem" tabindex="-1" @click=${run}>
    ${icon(name)}${words}<span class="r">${right}</span></button>`;
}

/** A row that asks for a frame: Enter or its button acts. */
export function field(name, words, value, last, act) {
  const run = (event) => {
    const input = event.currentTarget.closest('.mi').querySelector('input');
    const frame = Number(input.value);
    if (input.value.trim() === '' || !Number.isInteger(frame) || frame < 0 || frame > last) {
      input.setAttribute('aria-invalid', 'true');
      return;
    }
    close();
    act(frame);
  };
  return html`<div class="mi asks">${icon(name)}<label for="tmenu-frame">${words}</label>
    <input id="tmenu-frame" inputmode="numeric" autocomplete="off" .value=${String(value)}
      @input=${(event) => event.target.removeAttribute('aria-invalid')} />
    <button class="btn sm" @click=${run}>Do</button></div>`;
}

/** What else is to be known of it, in small. */
export function notes(list) {
  if (list.length === 0) return nothing;
  return html`<div class="says note"><span>${list.map((words) => html`${upper(words)}<br />`)}</span></div>`;
}

const upper = (words) => words.charAt(0).toUpperCase() + words.slice(1);

/** What a verdict says, above what can be done about it. */
export function sentence(name, state, range, words) {
  return html`<div class=${`says ${state}`}>${icon(name)}<span><b>${range}</b> ${words}</span></div>`;
}

function choices() {
  return [...host.querySelectorAll('button.mi, .asks input')];
}

/** Keys while the menu is open, heard before the page's own. */
function keys(event) {
  if (!isOpen()) return;
  const on = host.contains(event.target) ? event.target : null;
  if (event.key === 'Tab' || event.key === 'Escape') close();
  else if (event.key === 'ArrowDown') walk(1);
  else if (event.key === 'ArrowUp') walk(-1);
  else if (event.key === 'Enter' && on?.matches('input')) confirm(on);
  else if ((event.key === 'Enter' || event.key === ' ') && on?.matches('button')) on.click();
  else return;
  event.preventDefault();
  event.stopImmediatePropagation();
}

const confirm = (input) => input.parentElement.querySelector('.btn').click();

function walk(by) {
  const list = choices();
  const now = list.indexOf(document.activeElement);
  list.at(now < 0 ? Math.min(0, by) : (now + by) % list.length)?.focus();
}
