// The history: all steps that can be undone or redone, in a menu that hangs from undo.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { historyRows } from '../actions/history.js';
import { actionIcon, menuItem } from '../actions/buttons.js';
import { icon } from '../controls/icons.js';
import { heading, menuButton, menuHolder, toggleMenu } from '../controls/menu.js';
import { server } from '../store/state.js';
import { isNarrow, isTiny } from './more.js';

const NAME = 'history';

/** Undo and redo, the way to the list beside them. */
export function historyButtons() {
  const arrow = menuButton(NAME, { kind: 'ib slim', title: 'History', label: 'History', face: icon('chev') });
  return html`<span class="undoes" @contextmenu=${show}>
    ${actionIcon('undo', undefined, { size: '' })}${isTiny() ? nothing : actionIcon('redo', undefined, { size: '' })}
    ${menuHolder(NAME, () => (isNarrow() ? nothing : arrow), items, 'left history')}</span>`;
}

/** The right button on undo or redo. */
function show(event) {
  event.preventDefault();
  if (!event.target.closest('.menu')) toggleMenu(NAME);
}

function items() {
  const rows = historyRows(server.history);
  if (rows.length < 2) return [heading('Nothing has been changed yet')];
  return rows.map((row) => ('heading' in row ? heading(row.heading) : step(row)));
}

const step = ({ label, time, done, state }) =>
  menuItem('goToStep', done, { label, right: time, checked: state === 'here', kind: state });
