// Menus that hang from a button. One is open at a time; a click elsewhere or Esc closes it.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from './icons.js';
import { ui, setUi } from '../store/state.js';
import { reachedByKey } from './focus.js';

/** The entries of a menu: rows, headings, lines and notes. */
export const line = { line: true };
export const heading = (words) => ({ heading: words });
export const note = (content) => ({ note: content });

/**
 * A button with its menu below it.
 * button: (attributes of an open or shut menu) → template; items: () → entries
 */
export function menuHolder(name, button, items, side = 'left') {
  const open = ui.menu === name;
  return html`<span class="holder" data-menu=${name}>
    ${button(open)}${open ? menu(name, items(), side) : nothing}
  </span>`;
}

/** Open this menu, or close it when it is the open one. */
export function toggleMenu(name) {
  if (ui.menu === name) {
    closeMenu();
    return;
  }
  setUi('menu', name);
  // The menu is drawn with the next frame; only then can it take the keys.
  requestAnimationFrame(() => requestAnimationFrame(focusMenu));
}

/** Close what is open; tells whether anything was. */
export function closeMenu() {
  if (!ui.menu) return false;
  const opener = holder(ui.menu)?.querySelector('button');
  setUi('menu', null);
  if (reachedByKey()) opener?.focus();
  return true;
}

export function mountMenus() {
  addEventListener('pointerdown', closeFromOutside, true);
  addEventListener('blur', () => closeMenu());
}

function menu(name, entries, side) {
  return html`<div class="menu ${side}" role="menu" tabindex="-1" @keydown=${onKey}>
    ${entries.filter(Boolean).map(entry)}
  </div>`;
}

function entry(item) {
  if (item.line) return html`<hr />`;
  if (item.heading) return html`<div class="mh">${item.heading}</div>`;
  if (item.note) return html`<div class="mn">${item.note}</div>`;
  const role = item.checked === undefined ? 'menuitem' : 'menuitemradio';
  return html`<button
    class="mi"
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

function onKey(event) {
  const rows = [...event.currentTarget.querySelectorAll('.mi')];
  const at = rows.indexOf(document.activeElement);
  const to = {
    ArrowDown: (at + 1) % rows.length,
    ArrowUp: (at + rows.length - (at < 0 ? 0 : 1)) % rows.length,
    Home: 0,
    End: rows.length - 1,
  }[event.key];
  if (to !== undefined) rows[to].focus();
  else if (event.key === 'Tab') closeMenu();
  else if (!(at >= 0 && (event.key === 'Enter' || event.key === ' '))) return;
  event.stopPropagation();
  if (to !== undefined) event.preventDefault();
}

function focusMenu() {
  const list = ui.menu && holder(ui.menu)?.querySelector('.menu');
  if (!list) return;
  const target = reachedByKey() ? list.querySelector('.mi') : list;
  target?.focus();
}

function holder(name) {
  return document.querySelector(`[data-menu="${name}"]`);
}

function closeFromOutside(event) {
  if (ui.menu && !holder(ui.menu)?.contains(event.target)) closeMenu();
}
