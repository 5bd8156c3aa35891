// Sheets over the page. The browser's own dialog keeps the focus inside and closes on Esc.

import { ui, setUi } from '../store/state.js';

/** Open or close the sheet of keys. */
export const toggleSheet = () => setUi('sheet', !ui.sheet);

/** Close the sheets; tells whether one was open, or about to open with the next frame. */
export function closeSheets() {
  if (!ui.sheet && !ui.chooser) return false;
  setUi('sheet', false);
  setUi('chooser', null);
  return true;
}

/** A dialog in #screens; `closed` is called however it was closed. */
export function dialogIn(id, label, closed) {
  const dialog = document.createElement('dialog');
  dialog.id = id;
  dialog.className = 'sheet';
  dialog.setAttribute('aria-label', label);
  dialog.addEventListener('close', closed);
  // A click on the backdrop has the dialog itself as its target.
  dialog.addEventListener('pointerdown', (event) => {
    if (event.target === dialog) dialog.close();
  });
  document.getElementById('screens').append(dialog);
  return dialog;
}
