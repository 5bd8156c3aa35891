// The session in the address of the page, /?session=…, so that Back, Forward, reload and a bookmark
// lead to it. What stands there is the session's place among those that were opened: no secret.

import { listen, send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';

const NAME = 'session';
const ID = /^[0-9a-f]{16}$/;

/** The session that is on its way because the address asks for it, '' for the start screen. */
let wanted = null;
/** What was open at this tab's last server, and which server that was. */
let last = { server: undefined, id: '' };
ui.returning = false;

export function mountAddress() {
  addEventListener('popstate', () => lead(inAddress()));
  listen('note', ({ kind }) => kind === 'lost' && wanted !== null && giveUp());
  listen('refused', () => wanted !== null && giveUp());
  // At once, not with the next picture: the first answer names what was open when the page came.
  listen('state', ({ set }) => ('file' in set || 'server' in set) && follow());
}

function inAddress() {
  const id = new URLSearchParams(location.search).get(NAME) ?? '';
  return ID.test(id) ? id : '';
}

const openNow = () => server.file?.id ?? '';

/** Have the session of the address opened, or none. */
function lead(id) {
  if (server.file === undefined || id === (wanted ?? openNow())) return;
  wanted = id;
  send(id ? { do: 'open', kind: 'recent', id } : { do: 'close' });
}

/** The address names what is open, whoever opened it. */
function follow() {
  if (server.file === undefined) return;
  const id = openNow();
  const isFirst = last.server === undefined;
  const isRestarted = !isFirst && last.server !== server.server;
  if (isFirst) arrive(id);
  else if (isRestarted && !id && last.id) comeBack(last.id);
  else if (id !== last.id || wanted !== null) keepUp(id);
  last = { server: server.server, id: id || (wanted ?? '') };
}

/** A page that was opened by its address, such as a bookmark, opens that session. One that a browser
 * has put back does so only where nothing is open: another may have been opened since. */
function arrive(id) {
  const named = inAddress();
  const [visit] = /** @type {PerformanceNavigationTiming[]} */ (performance.getEntriesByType('navigation'));
  if (named && named !== id && (!id || visit?.type === 'navigate')) lead(named);
  else write(id, 'replace');
}

/** Keypose was started again with nothing open: what this tab had open is opened again. */
function comeBack(id) {
  setUi('returning', true);
  lead(id);
}

function keepUp(id) {
  if (wanted !== null && id !== wanted) return; // closed on the way to the one that is wanted
  wanted = null;
  setUi('returning', false);
  // A tab that only looks on while another opens something has not been led anywhere.
  write(id, document.hasFocus() ? 'push' : 'replace');
}

/** It cannot be opened or closed, for a reason that is said: the address names what is open. */
function giveUp() {
  wanted = null;
  setUi('returning', false);
  last.id = openNow();
  write(openNow(), 'replace');
}

/** @param {'push' | 'replace'} how */
function write(id, how) {
  if (id === inAddress()) return;
  const address = id ? `/?${NAME}=${id}` : '/';
  if (how === 'push') history.pushState(null, '', address);
  else history.replaceState(null, '', address);
}
