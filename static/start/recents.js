// The recent sessions: picture, name, a strip of verdicts, when; and what is missing.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { ui, setUi } from '../store/state.js';
import { count, longAgo } from '../controls/words.js';
import { openChooser } from '../controls/dialogs.js';
import { smallPicture } from './picture.js';
import { isRenamed, onSessionKey, openSessionMenu, renameBox } from './session_menu.js';

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
    ${found.filter(({ missing }) => missing).slice(0, MOST_MOVED).map(movedCard)}`;
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
    <button class="rec" title=${path} @click=${() => open(recent)}>${face(html`<span class="b">${name}</span>`)}</button>
    <button class="ib more" title="Rename, duplicate, delete" aria-label="Menu of ${name}" aria-haspopup="menu" @click=${menu}>
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
    <button class="ib more" title="Duplicate, delete" aria-label="Menu of ${recent.name}" aria-haspopup="menu" @click=${menu}>
      ${icon('more')}
    </button>
  </div>`;
}
