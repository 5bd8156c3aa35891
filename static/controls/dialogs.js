// Sheets over the page. The browser's own dialog keeps the focus inside and closes on Esc.

import { nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from './focus.js';
import { loadLibrary } from '../store/library.js';
import { setUi, ui, watch } from '../store/state.js';

/** @typedef {import('../store/shapes.js').Watched} Watched */

/** @type {('sheet' | 'chooser' | 'search' | 'exporting' | 'importing')[]} */
const SHEETS = ['sheet', 'chooser', 'search', 'exporting', 'importing'];

/** Open or close the sheet of keys. */
export const toggleSheet = () => setUi('sheet', !ui.sheet);

/** Open or close the command search; `kind`: of entries, where not all are searched. */
export function toggleSearch(kind = 'All') {
  if (!ui.search) loadLibrary();
  setUi('search', ui.search ? null : kind);
}

/** Show the files that can be opened; `lost` is a recent session whose video is looked for. */
export function openChooser(kind, lost = null) {
  loadLibrary();
  setUi('fileFind', '');
  setUi('chooser', { kind, lost });
}

/** Close the sheets; returns whether one was open, or about to open with the next frame. */
export function closeSheets() {
  if (SHEETS.every((name) => !ui[name])) return false;
  for (const name of SHEETS) setUi(name, null);
  return true;
}

/**
 * A dialog, open while `ui[name]` holds something, and drawn when that or any of `names` changes.
 * @param {{ id: string, label: string, name: typeof SHEETS[number], names: Watched[], draw: () => unknown }} spec
 */
export function mountDialog({ id, label, name, names, draw }) {
  const dialog = addOnTop(id, 'dialog');
  dialog.className = 'sheet';
  dialog.setAttribute('aria-label', label);
  let isClosing = false; // by the page, which may have opened it again until the browser reports it
  dialog.addEventListener('close', () => {
    if (!isClosing) setUi(name, null);
    isClosing = false;
  });
  // A click on the backdrop has the dialog itself as its target.
  dialog.addEventListener('pointerdown', (event) => {
    if (event.target === dialog) dialog.close();
  });
  watch([`u:${name}`, ...names], () => {
    render(ui[name] ? draw() : nothing, dialog);
    if (ui[name] && !dialog.open) dialog.showModal();
    if (ui[name] || !dialog.open) return;
    isClosing = true;
    dialog.close();
  });
}
