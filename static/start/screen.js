// The start screen: what to see while nothing is open.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { addOnTop } from '../controls/focus.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, ui, setUi, watch } from '../store/state.js';
import { openChooser } from '../controls/dialogs.js';
import { loadLibrary } from '../store/library.js';
import { smallPicture } from './picture.js';
import { recentSessions } from './recents.js';
import { uploadCard } from './uploading.js';

const STEPS = [
  ['Box', 'Draw a box around the person: every frame gets a draft.'],
  ['Confirm', 'Correct the drafts that are least sure, press K.'],
  ['Track', 'Press T. The frames between are filled in while you watch.'],
  ['Stand on the floor', 'Press Shift F. Feet that stand still no longer slide.'],
  ['Review', 'Press Shift R. The least certain places, the worst first.'],
];

let wasShown = false;

export function mountStart() {
  const place = addOnTop('empty', 'main');
  /** @type {import('../store/shapes.js').Watched[]} */
  const own = ['u:library', 'u:upload', 'u:dropping', 'u:find', 'u:connected', 'u:renaming'];
  watch(['file', ...own], () => {
    const isShown = !server.file;
    if (isShown && !wasShown) arrive();
    wasShown = isShown;
    place.hidden = !isShown;
    // What lies below can be neither seen nor reached.
    for (const id of ['stage', 'time']) document.getElementById(id).inert = isShown;
    render(isShown ? content() : nothing, place);
  });
}

function arrive() {
  document.activeElement?.blur?.();
  setUi('find', '');
  setUi('playing', false);
  loadLibrary();
}

function content() {
  // Before the server's first word it is not known whether anything is open.
  if (server.file === undefined) return html`<p class="dim waiting">Connecting…</p>`;
  const recents = recentSessions();
  return html`<div class="card ${recents === nothing ? 'alone' : ''}">
    <div>${dropZone()}${samples()}${privacyNote()}</div>
    ${recents === nothing ? nothing : html`<div class="stack recents">${recents}</div>`}
    <div class="how">
      ${STEPS.map(
        ([title, text], i) => html`<div><i>${i + 1}</i><b>${title}</b><span class="mut">${text}</span></div>`,
      )}
    </div>
  </div>`;
}

/** The samples that are offered, in the order in which the server has them. */
const SAMPLE_TITLES = { walk: 'Try a walk', balance: 'Try a balance beam', arms: 'Try surfaces' };

function dropZone() {
  return html`<div class="stack dz ${ui.dropping ? 'over' : ''}">
    ${PICTURE}
    <h1>Drop a video here</h1>
    <p class="mut">
      Draw a box around a person, or pose a thing.<br />Keypose finds the motion in every frame.
    </p>
    ${ui.upload ? uploadCard() : buttons()}
    <p class="dim kinds">
      MP4, MOV, MKV, WebM, AVI and others · one camera, still or moving<br />or a mesh sequence (3D scans):
      <button class="textlink" @click=${() => openChooser('meshes')}>Choose surfaces…</button>
    </p>
  </div>`;
}

function buttons() {
  return html`<div class="row choices">
    <button class="btn pri" @click=${() => openChooser('video')}>${icon('folder')}Choose a video…</button>
    <button class="btn" @click=${() => openChooser('session')}>${icon('up')}Open a session…</button>
  </div>`;
}

/** A film to try, and surfaces. */
function samples() {
  const shown = (ui.library?.samples ?? []).filter(({ id }) => SAMPLE_TITLES[id]);
  if (!shown.length) return nothing;
  return html`<div class="samples">${shown.map((one) => sample(one, SAMPLE_TITLES[one.id]))}</div>`;
}

function sample({ id, thumb, words }, title) {
  return html`<button class="rec sample" @click=${() => send({ do: 'open', kind: 'sample', id })}>
    ${smallPicture({ address: thumb })}
    <span><span class="b">${title}</span><br /><span class="mut">${words}</span></span>
    <span class="btn sm">Open</span>
  </button>`;
}

const privacyNote = () => html`<div class="dim row promise">
  ${icon('lock')}Runs on this computer only. No video leaves it.
</div>`;

const PICTURE = html`<svg width="88" height="88" viewBox="0 0 88 88" fill="none" aria-hidden="true">
  <rect x="8" y="18" width="72" height="52" rx="6" stroke="var(--line2)" stroke-width="1.5" />
  <path
    d="M22 56c9-1 10-22 22-22s13 17 22 14"
    stroke="var(--acc)"
    stroke-width="2.4"
    stroke-linecap="round"
  />
  <path
    d="M22 49.5l6.5 6.5-6.5 6.5-6.5-6.5zM44 27.5l6.5 6.5-6.5 6.5-6.5-6.5zM66 41.5l6.5 6.5-6.5 6.5-6.5-6.5z"
    fill="var(--t1)"
  />
</svg>`;
