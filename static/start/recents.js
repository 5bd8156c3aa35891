// The recent sessions: picture, name, verdicts, when; and what can be done with each.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { perform } from '../actions/actions.js';
import { menuItem } from '../actions/buttons.js';
import { openChooser } from '../controls/dialogs.js';
import { icon } from '../controls/icons.js';
import { line, openMenuAt } from '../controls/menu.js';
import { count, longAgo } from '../controls/words.js';
import { send } from '../store/link.js';
import { server, setUi, ui } from '../store/state.js';
import { smallPicture } from './picture.js';

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
    .value=${session.name} @keydown=${(event) => onRenameKey(event, session)} @blur=${(event) => finish(event, session)}
      />`;
}

function onRenameKey(event, session) {
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

const WIDTH = 220; // of a strip, px
const MOST_MOVED = 2; // shown at once; Find shows the others

/** The right half of the start screen. */
export function recentSessions() {
  const recents = ui.library?.recents ?? [];
  if (!recents.length) return nothing;
  const wanted = (ui.find ?? '').trim().toLowerCase();
  const found = recents.filter(({ name, video }) => `${name} ${video}`.toLowerCase().includes(wanted));
  return html`<div class="row rechead">
      <span class="title">Recent sessions</span><span class="sp"></span>
      <input
        class="findbox"
        type="search"
        placeholder="Find"
        aria-label="Find a session"
        .value=${ui.find ?? ''}
        @input=${(event) => setUi('find', event.target.value)}
        @keydown=${(event) => onKey(event, found)}
      />
    </div>
    <div class="reclist">
      ${found.filter(({ missing }) => !missing).map(row)}
      ${found.length ? nothing : html`<p class="dim nothing">No session is named “${ui.find}”.</p>`}
    </div>
    ${found
      .filter(({ missing }) => missing)
      .slice(0, MOST_MOVED)
      .map(movedCard)}`;
}

function onKey(event, found) {
  const first = found.find(({ missing }) => !missing);
  if (event.key === 'Enter' && first) open(first);
  if (event.key !== 'Escape') return;
  event.stopPropagation();
  setUi('find', '');
  event.target.blur();
}

const open = ({ id }) => send({ do: 'open', kind: 'recent', id });

function row(recent) {
  const { name, keyframes, frames, strip, thumb, path } = recent;
  const face = (title) => html`${smallPicture({ address: thumb })}
    <span class="what"
      >${title}
      <span class="mut num">${count(keyframes, 'keyframe')} · ${count(frames, 'frame')}</span>
      ${verdicts(strip ?? [])}</span
    >
    <span class="dim num">${longAgo(recent.opened_at)}</span>`;
  if (isRenamed(recent.id)) return html`<div class="recrow"><div class="rec">${face(renameBox(recent))}</div></div>`;
  const menu = (event) => openSessionMenu(event, recent);
  return html`<div class="recrow" @contextmenu=${menu} @keydown=${(event) => onSessionKey(event, recent)}>
    <button class="rec" title=${path}
      @click=${() => open(recent)}>${face(html`<span class="b">${name}</span>`)}</button>
    <button class="ib more" title="Rename, duplicate, delete" aria-label="Menu of ${name}" aria-haspopup="menu"
      @click=${menu}>
      ${icon('more')}
    </button>
  </div>`;
}

/** strip: [[state, frames], …] from the first keyframe to the last. */
function verdicts(strip) {
  const total = strip.reduce((sum, [, frames]) => sum + frames, 0);
  if (!total) return nothing;
  let x = 0;
  const pieces = strip.map(([state, frames]) => {
    const width = (WIDTH * frames) / total;
    const from = x;
    x += width;
    return piece(state, from, Math.max(1, width - 1));
  });
  const words = strip.map(([state]) => state).join(', ');
  return html`<svg class="strip" width=${WIDTH} height="6" role="img" aria-label=${words}>
    ${patterns()}${pieces}
  </svg>`;
}

function piece(state, x, width) {
  if (state === 'outdated' || state === 'tracking' || state === 'waiting') {
    return svg`<rect class="old" x=${x + 0.5} y=".5" width=${Math.max(1, width - 1)} height="5" />`;
  }
  return svg`<rect class=${state} x=${x} width=${width} height="6" />`;
}

const patterns = () => svg`<defs>
  <pattern id="strip-check" width="7" height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="ground" width="7" height="7" /><rect class="check" width="3.5" height="7" />
  </pattern>
  <pattern id="strip-lost" width="5" height="5" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="ground" width="5" height="5" /><path class="lost" d="M0 0H5M0 0V5" />
  </pattern>
</defs>`;

function movedCard(recent) {
  const { video, keyframes, exchanged } = recent;
  const menu = (event) => openSessionMenu(event, recent, false);
  return html`<div class="moved recrow" @contextmenu=${menu} @keydown=${(event) => onSessionKey(event, recent)}>
    <span class="sign">${icon('warn')}</span>
    <span
      ><b>${video} ${exchanged ? 'is another video now' : 'was moved'}.</b>
      <span class="mut">Its session is safe: ${count(keyframes, 'keyframe')}.</span><br />
      <button class="textlink" @click=${() => openChooser('video', recent)}>Find the video…</button>
    </span>
    <button class="ib more" title="Duplicate, delete" aria-label="Menu of ${recent.name}" aria-haspopup="menu"
      @click=${menu}>
      ${icon('more')}
    </button>
  </div>`;
}
