// The command search: a field, and below it what can be done, with its key or why it cannot. A combobox
// with its listbox: the focus stays in the field, arrow keys choose, Enter does it.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { perform } from '../actions/actions.js';
import { found, runEntry } from '../actions/search.js';
import { mountDialog } from '../controls/dialogs.js';
import { icon } from '../controls/icons.js';
import { closeMenu } from '../controls/menu.js';
import { server, setUi, ui, watch } from '../store/state.js';

const PAGE = 8;
let query = '';
let at = 0;

export function mountSearch() {
  mountDialog({
    id: 'search',
    label: 'Search commands',
    name: 'search',
    names: ['file', 'body', 'view', 'keys', 'segments', 'undo', 'u:library'],
    draw: dialog,
  });
  watch(['u:search'], follow);
  watch(['u:seek', 'u:tab', 'view'], seek);
  // Before the browser, whose own search it would open, and before a field that keeps its keys.
  addEventListener('keydown', openWithKey, true);
}

function openWithKey(event) {
  const isOurs =
    (event.ctrlKey || event.metaKey) && !event.shiftKey && !event.altKey && event.key.toLowerCase() === 'k';
  if (!isOurs || event.isComposing) return;
  event.preventDefault();
  event.stopPropagation();
  if (event.repeat || ui.dragging || ui.chooser || ui.sheet) return;
  closeMenu();
  perform('search');
}

/** It opens empty, at the first that can be done; the dialog gives the focus back when it closes. */
function follow() {
  if (ui.search) {
    query = '';
    at = Math.max(
      0,
      found('', ui.search).findIndex(({ off }) => !off),
    );
    const input = document.querySelector('#search input');
    if (input instanceof HTMLInputElement) input.value = '';
  }
}

function dialog() {
  const entries = found(query, ui.search);
  at = Math.min(at, Math.max(0, entries.length - 1));
  const isAll = ui.search === 'All';
  const grouped = isAll && !query.trim();
  return html`<div class="in stack palette" @keydown=${onKey}>
    <div class="row ask">${icon('find')}<input type="text" role="combobox" aria-expanded="true" aria-autocomplete="list"
        aria-controls="search-list" aria-activedescendant=${entries.length ? `search-${at}` : nothing}
          aria-label="Search commands"
        placeholder=${
          isAll ? 'Search commands, parts, settings, notes, or type a frame' : `Search ${ui.search.toLowerCase()}s`
        } autocomplete="off" spellcheck="false" maxlength="80" autofocus
        @input=${(event) => look(event.target.value)} /><kbd>Esc</kbd></div>
    <div class="found" id="search-list" role="listbox" aria-label="Commands">
      ${entries.map(
        (entry, i) =>
          html`${
            grouped && entry.group !== entries[i - 1]?.group
              ? html`<div class="mh" role="presentation">${entry.group}</div>`
              : nothing
          }${row(entry, i)}`,
      )}
      ${entries.length ? nothing : html`<p class="dim nothing">Nothing is called “${query.trim()}”.</p>`}
    </div>
    <span class="unseen" role="status">${query.trim() ? `${entries.length} found` : ''}</span>
  </div>`;
}

function row(entry, i) {
  const { title, off, key, on, more, side, icon: sign, kind } = entry;
  return html`<div class="row hit ${i === at ? 'hov' : ''} ${off ? 'off' : ''}" role="option" id=${`search-${i}`}
    aria-selected=${i === at} aria-disabled=${off ? 'true' : nothing}
    @pointermove=${() => point(i)} @click=${() => choose(entry)}>
    ${
      side
        ? html`<span class="dot"
      style=${`background:var(--${side})`}></span>`
        : sign
          ? icon(sign)
          : html`<span class="i"></span>`
    }
    <span class="tt cut">${title}</span>
    ${on ? html`<span class="isOn">${kind === 'Part' ? 'selected' : 'on'}</span>` : nothing}
    <span class="sp"></span>
    <span class="why cut">${off || more}</span>${key ? html`<kbd>${key}</kbd>` : nothing}
  </div>`;
}

const redraw = () => render(dialog(), document.getElementById('search'));

function look(text) {
  [query, at] = [text, 0];
  redraw();
  document.querySelector('#search .found')?.scrollTo(0, 0);
}

function point(i) {
  if (i === at) return;
  at = i;
  redraw();
}

function onKey(event) {
  const entries = found(query, ui.search);
  const last = Math.max(0, entries.length - 1);
  const to = {
    ArrowDown: at === last ? 0 : at + 1,
    ArrowUp: at === 0 ? last : at - 1,
    PageDown: Math.min(last, at + PAGE),
    PageUp: Math.max(0, at - PAGE),
  }[event.key];
  if (to !== undefined) {
    event.preventDefault();
    point(to);
    document.getElementById(`search-${at}`)?.scrollIntoView({ block: 'nearest' });
  } else if (event.key === 'Enter' && !event.isComposing) {
    event.preventDefault();
    if (entries[at]) choose(entries[at]);
  } else if (event.key === 'Tab') {
    event.preventDefault();
  }
  event.stopPropagation();
  if (event.key !== 'Escape') return;
  event.preventDefault();
  setUi('search', null);
}

/** What cannot be done says why where it stands, and stays open. */
function choose(entry) {
  if (entry.off) return;
  setUi('search', null);
  // Once the dialog has let go of the focus, so that what opens now can take it.
  requestAnimationFrame(() => requestAnimationFrame(() => runEntry(entry)));
}

/** A setting that was chosen is brought into sight, and shown for a moment. */
function seek() {
  const wanted = ui.seek;
  if (!wanted || !server.file) return;
  setUi('seek', null);
  requestAnimationFrame(() =>
    requestAnimationFrame(() => {
      const section = document.querySelector(`#insp-body section[aria-label="${wanted}"]`);
      section?.scrollIntoView({ block: 'nearest' });
      if (!matchMedia('(prefers-reduced-motion: reduce)').matches) {
        section?.animate?.([{ background: 'var(--acc-soft)' }, { background: 'transparent' }], { duration: 900 });
      }
      const isClosed = !document.querySelector('#insp')?.classList.contains('open');
      const tag = document.querySelector('.insp-tag button');
      if (isClosed && tag instanceof HTMLElement && tag.offsetParent !== null) tag.click();
    }),
  );
}
