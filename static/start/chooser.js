// The sheet that lists the files of the folders Keypose may see, and takes one from elsewhere.

import { clamp } from '../controls/arithmetic.js';
import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { ui, setUi } from '../store/state.js';
import { mountDialog } from '../controls/dialogs.js';
import { bytes, joined, longAgo } from '../controls/words.js';
import { videoSuffixes } from '../store/library.js';
import { takeFiles } from './uploading.js';

const KINDS = { any: null, video: ['video', 'images'], meshes: ['meshes'], session: ['session'] };
const TITLES = { any: 'Open', video: 'Choose a video', meshes: 'Choose surfaces', session: 'Open a session' };
const ICONS = { video: 'film', images: 'img', meshes: 'both', session: 'key' };
const MOST = 300; // rows; more are found by name

export function mountChooser() {
  mountDialog({ id: 'chooser', label: 'Choose a file', name: 'chooser', names: ['u:library', 'u:fileFind'], draw: sheet });
}

function sheet() {
  const { kind, lost } = ui.chooser;
  const found = files(kind);
  return html`<div class="in" @keydown=${onKey}>
    <div class="row sheethead">
      <span class="title">${lost ? `Find ${lost.video}` : TITLES[kind]}</span><span class="sp"></span>
      <input
        class="findbox"
        type="search"
        placeholder="Find"
        aria-label="Find a file"
        autofocus
        .value=${ui.fileFind ?? ''}
        @input=${(event) => setUi('fileFind', event.target.value)}
      />
      <button class="ib" title="Close" data-key="Esc" aria-label="Close" @click=${close}>${icon('x')}</button>
    </div>
    <div class="filelist">${found.length ? byFolder(found.slice(0, MOST)) : none()}</div>
    <div class="row sheetfoot">
      <span class="dim">${footnote(found.length)}</span><span class="sp"></span>
      ${kind === 'session' || lost ? nothing : elsewhere()}
    </div>
  </div>`;
}

const close = () => setUi('chooser', null);

function files(kind) {
  const wanted = (ui.fileFind ?? '').trim().toLowerCase();
  return (ui.library?.files ?? []).filter(
    (file) =>
      (KINDS[kind]?.includes(file.kind) ?? true) &&
      `${file.folder}/${file.name}`.toLowerCase().includes(wanted),
  );
}

function byFolder(found) {
  const folders = Map.groupBy
    ? Map.groupBy(found, ({ folder }) => folder)
    : found.reduce((map, one) => map.set(one.folder, [...(map.get(one.folder) ?? []), one]), new Map());
  return [...folders].map(
    ([folder, inside]) => html`<h3 class="path">${icon('folder')}${folder}</h3>
      ${inside.map(row)}`,
  );
}

function row(file) {
  const size = file.count ? `${file.count} ${file.kind}` : bytes(file.bytes);
  return html`<button class="filerow" @click=${() => choose(file)}>
    ${icon(ICONS[file.kind])}<span class="cut">${file.name}</span><span class="sp"></span>
    <span class="dim num">${file.kind === 'session' ? 'session' : size}</span>
    <span class="dim num when">${longAgo(file.modified_at)}</span>
  </button>`;
}

function choose({ id }) {
  const { lost } = ui.chooser;
  close();
  if (lost) send({ do: 'open', kind: 'recent', id: lost.id, video: id });
  else send({ do: 'open', kind: 'file', id });
}

function none() {
  if (!ui.library) return html`<p class="dim nothing">Looking…</p>`;
  return html`<p class="dim nothing">
    ${ui.fileFind ? html`No file is named “${ui.fileFind}”.` : nowhere()}
  </p>`;
}

function footnote(found) {
  if (ui.library?.more || found > MOST) return 'There are more files. Search by name.';
  const roots = ui.library?.folders ?? [];
  if (!roots.length || !found) return '';
  return ui.chooser.lost ? nowhere() : `From ${roots.join(', ')}`;
}

/** Which folders were looked into, and what to do when it lies in another. */
function nowhere() {
  const { kind, lost } = ui.chooser;
  const roots = ui.library?.folders ?? [];
  const what = lost ? lost.video : { session: 'a session', meshes: 'surfaces' }[kind] ?? 'a video';
  // A copy of a video that was moved would not be the session's own.
  const drop = lost || kind === 'session' || kind === 'meshes' ? '' : ', or drop the video here';
  const listing = roots.length ? `Showing ${joined(roots)}` : 'No folder to show';
  return `${listing}. For ${what} in another folder, start Keypose there${drop}.`;
}

/** A video that lies in another folder is copied into Keypose's own. */
function elsewhere() {
  return html`<label class="btn filebtn">
    ${icon('up')}From elsewhere…
    <input type="file" accept=${['video/*', ...(videoSuffixes() ?? [])].join()} @change=${onPick} />
  </label>`;
}

function onPick(event) {
  const chosen = [...event.target.files];
  event.target.value = '';
  if (!chosen.length) return;
  close();
  takeFiles(chosen);
}

/** Arrows walk through the rows, from the Find box too; Enter there opens the first. */
function onKey(event) {
  const rows = [...event.currentTarget.querySelectorAll('.filerow')];
  const at = rows.indexOf(document.activeElement);
  const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
  if (step && rows.length) {
    event.preventDefault();
    rows[clamp(at + step, 0, rows.length - 1)].focus();
  } else if (event.key === 'Enter' && event.target.type === 'search') rows[0]?.click();
}
