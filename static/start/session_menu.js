// What can be done with a whole session: its menu, and the box in which it is renamed.

import { html } from '../vendor/lit-html/lit-html.js';
import { perform } from '../actions/actions.js';
import { menuItem } from '../actions/buttons.js';
import { line, openMenuAt } from '../controls/menu.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';

const LONGEST = 120; // characters of a name

/** @typedef {{ id: string, name: string }} Named  A session, by its place among the recent ones. */

/** The entries that concern the session itself. @param {Named} session */
export const sessionEntries = (session) => [
  menuItem('renameSession', session, { right: 'F2' }),
  menuItem('duplicateSession', session),
  menuItem('deleteSession', session, { right: 'Delete' }),
];

/** The menu of a session that is not open. @param {Named} session */
export function openSessionMenu(event, session, hasVideo = true) {
  event.preventDefault();
  const box = event.currentTarget.getBoundingClientRect();
  const isPointed = event.type === 'contextmenu' && event.clientX > 0;
  /** @type {[number, number]} */
  const place = isPointed ? [event.clientX, event.clientY] : [box.left, box.bottom];
  const entries = sessionEntries(session);
  const open = menuItem('openRecent', session, { label: 'Open', right: 'Enter' });
  // The card of one whose video is gone has no room for a box to rename it in.
  openMenuAt(session.name, hasVideo ? [open, line, ...entries] : entries.slice(1), place);
}

/** F2 and Delete on a session of a list. @param {Named} session */
export function onSessionKey(event, session) {
  const act = { F2: 'renameSession', Delete: 'deleteSession' }[event.key];
  if (!act) return;
  event.preventDefault();
  event.stopPropagation();
  perform(/** @type {import('../actions/actions.js').ActionId} */ (act), session);
}

/** Whether the name of this session is being changed. */
export const isRenamed = (id) => ui.renaming === id;

/** The box for another name: Enter takes it, Esc leaves it as it was. @param {Named} session */
export function renameBox(session) {
  requestAnimationFrame(() => {
    const box = /** @type {HTMLInputElement | null} */ (document.querySelector('.renamebox'));
    if (!box || box.dataset.ready) return;
    box.dataset.ready = 'yes';
    box.focus();
    box.select();
  });
  return html`<input class="renamebox findbox" aria-label="Name of the session" maxlength=${LONGEST}
    .value=${session.name} @keydown=${(event) => onKey(event, session)} @blur=${(event) => finish(event, session)} />`;
}

function onKey(event, session) {
  event.stopPropagation();
  if (event.key === 'Enter') finish(event, session);
  else if (event.key === 'Escape') setUi('renaming', null);
}

function finish({ target }, { id, name }) {
  if (!isRenamed(id)) return;
  setUi('renaming', null);
  const title = target.value.trim();
  if (title === name) return;
  // Of the open session it is an edit like any other, and can be undone.
  if (server.file?.id === id) send({ do: 'rename', title });
  else send({ do: 'rename_session', id, title });
}
