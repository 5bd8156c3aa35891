// The sheet that walks through the folders Keypose may see, finds by name, and takes a file from
// elsewhere.

import { clamp } from '../controls/arithmetic.js';
import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { ui, setUi, watch } from '../store/state.js';
import { mountDialog } from '../controls/dialogs.js';
import { bytes, count, joined, longAgo } from '../controls/words.js';
import { enterFolder, enterLastFolder, videoSuffixes } from '../store/library.js';
import { smallPicture } from './picture.js';
import { heldIn, sorted } from './sorting.js';
import { takeFiles } from './uploading.js';

const KINDS = {
  any: null,
  video: ['video', 'images'],
  film: ['video', 'images'],
  meshes: ['meshes'],
  session: ['session'],
};
const TITLES = {
  any: 'Open',
  video: 'Choose a video',
  film: 'Add a film of the same motion',
  meshes: 'Choose surfaces',
  session: 'Open a session',
};
const SIGNS = { video: 'film', images: 'img', meshes: 'both', session: 'key' };
const KIND_LABELS = { video: 'Video', images: 'Images', meshes: 'Meshes', session: 'Session' };
const COLUMNS = { name: 'Name', size: 'Size', date: 'Date' };
const NEWEST = 30;
const MOST = 300; // rows; more are found by name

export function mountChooser() {
  mountDialog({
    id: 'chooser',
    label: 'Choose a file',
    name: 'chooser',
    names: ['u:library', 'u:fileFind', 'u:place', 'u:fileSort'],
    draw: dialog,
  });
  let wasOpen = false;
  watch(['u:chooser'], () => {
    if (ui.chooser && !wasOpen) enterLastFolder();
    wasOpen = Boolean(ui.chooser);
  });
}

function dialog() {
  const { kind, lost } = ui.chooser;
  const isSearch = Boolean(wanted());
  const folders = isSearch ? [] : (ui.place?.folders ?? []);
  const isTop = !isSearch && ui.place?.way.length === 0;
  const files = isTop
    ? newest(kind)
    : sorted(isSearch ? found(kind) : ofKind(ui.place?.files ?? [], kind), ui.fileSort);
  return html`<div class="in stack" @keydown=${onKey}>
    <div class="row sheethead">
      <span class="title">${lost ? `Find ${lost.video}` : TITLES[kind]}</span><span class="sp"></span>
      <input
        class="findbox"
        type="search"
        placeholder="Find in all folders"
        aria-label="Find a file"
        autofocus
        .value=${ui.fileFind ?? ''}
        @input=${(event) => setUi('fileFind', event.target.value)}
      />
      <button class="ib" title="Close" data-key="Esc" aria-label="Close" @click=${close}>${icon('x')}</button>
    </div>
    ${isSearch ? nothing : way()}
    ${files.length && !isTop ? columns() : nothing}
    <div class="filelist" role="group" aria-label="Files">
      ${folders.map(folderRow)}${isTop && files.length ? html`<h3>Newest in these folders</h3>` : nothing}
      ${files.slice(0, MOST).map((file) => fileRow(file, isSearch || isTop))}
      ${folders.length + files.length ? nothing : none(isSearch)}
    </div>
    <div class="row sheetfoot">
      <span class="dim">${footnote(files.length, isSearch)}</span><span class="sp"></span>
      ${kind === 'session' || lost ? nothing : elsewhere()}
    </div>
  </div>`;
}

const close = () => setUi('chooser', null);
const wanted = () => (ui.fileFind ?? '').trim().toLowerCase();
const ofKind = (files, kind) => files.filter((file) => KINDS[kind]?.includes(file.kind) ?? true);

const found = (kind) =>
  ofKind(ui.library?.files ?? [], kind).filter((file) =>
    `${file.folder}/${file.name}`.toLowerCase().includes(wanted()),
  );

/** What was made last, in all folders: what is looked for is mostly among it. */
const newest = (kind) => sorted(ofKind(ui.library?.files ?? [], kind), { by: 'date', down: true }).slice(0, NEWEST);

// --- where one is

/** The way from the folders there are to this one. */
function way() {
  const places = ui.place?.way ?? [];
  return html`<nav class="way row" aria-label="Folder">
    <button class="ib s" title="Up" data-key="Backspace" aria-label="Up" ?disabled=${!places.length}
      @click=${up}><span class="turned">${icon('chev')}</span></button>
    <button class="crumb" ?disabled=${!places.length} @click=${() => enterFolder('')}>Folders</button>
    ${places.map(
      (
        { id, name },
        i,
      ) => html`${icon('chr')}<button class="crumb cut" aria-current=${i === places.length - 1 ? 'page' : nothing}
      @click=${() => enterFolder(id)}>${name}</button>`,
    )}
  </nav>`;
}

function up() {
  const places = ui.place?.way ?? [];
  if (places.length) enterFolder(places.at(-2)?.id ?? '');
}

// --- the rows

function columns() {
  const { by, down } = ui.fileSort ?? { by: 'name', down: false };
  const column = ([
    id,
    label,
  ]) => html`<button class="row fcol ${id}" aria-pressed=${by === id} title="Sort by ${label.toLowerCase()}"
    @click=${() => setUi('fileSort', { by: id, down: by === id ? !down : id !== 'name' })}>
    ${label}${by === id ? html`<span class="dir ${down ? '' : 'turned'}">${icon('chev')}</span>` : nothing}
  </button>`;
  return html`<div class="fcols">${Object.entries(COLUMNS).map(column)}</div>`;
}

function folderRow({ id, name }) {
  const held = heldIn(id, ofKind(ui.library?.files ?? [], ui.chooser.kind));
  // What was not looked through to its end may hold more than is known.
  const isEmpty = !held && ui.library && !ui.library.more;
  return html`<button class="filerow folder ${isEmpty ? 'bare' : ''}" @click=${() => enterFolder(id)}>
    <span class="th">${icon('folder')}</span><span class="cut">${name}</span>
    <span class="dim num bytes">${
      held ? `${held}${ui.library.more ? '+' : ''}` : isEmpty ? 'Nothing found' : ''
    }</span><span></span>
  </button>`;
}

function fileRow(file, hasFolder) {
  const size = file.count
    ? count(file.count, file.kind === 'images' ? 'image' : 'mesh').replace('meshs', 'meshes')
    : bytes(file.bytes);
  const address = file.kind === 'meshes' ? '' : `/file.jpg?${new URLSearchParams({ at: file.id })}`;
  return html`<button class="filerow ${file.kind}" title=${`${file.folder}/${file.name}`} @click=${() => choose(file)}>
    ${smallPicture({ address, own: true, sign: SIGNS[file.kind] })}
    <span class="what cut">${file.name}<span class="kind ${file.kind}">${icon(SIGNS[file.kind])}${KIND_LABELS[file.kind]}</span>
      ${hasFolder ? html`<span class="dim cut">${file.folder}</span>` : nothing}</span>
    <span class="dim num bytes">${file.kind === 'session' ? '' : size}</span>
    <span class="dim num when">${longAgo(file.modified_at)}</span>
  </button>`;
}

function choose({ id }) {
  const { kind, lost } = ui.chooser;
  close();
  if (kind === 'film') send({ do: 'add_film', kind: 'file', id });
  else if (lost) send({ do: 'open', kind: 'recent', id: lost.id, video: id });
  else send({ do: 'open', kind: 'file', id });
}

function none(isSearch) {
  if (isSearch ? !ui.library : !ui.place) return html`<p class="dim nothing">Looking…</p>`;
  const what = { session: 'session', meshes: 'surfaces', any: 'video or session' }[ui.chooser.kind] ?? 'video';
  return html`<p class="dim nothing">${
    isSearch ? html`No file is named “${ui.fileFind}”.` : `No ${what} in this folder.`
  }</p>`;
}

function footnote(many, isSearch) {
  if ((isSearch ? ui.library?.more : ui.place?.more) || many > MOST) return 'There are more files. Search by name.';
  return nowhere();
}

/** Which folders can be looked into, and what to do when it lies in another. */
function nowhere() {
  const { kind, lost } = ui.chooser;
  const roots = ui.library?.folders ?? [];
  const what = lost ? lost.video : ({ session: 'a session', meshes: 'surfaces' }[kind] ?? 'a video');
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
  const { kind } = ui.chooser;
  close();
  takeFiles(chosen, kind === 'film');
}

/** Arrows walk through the rows, from the Find box too; Enter there opens the first. Backspace goes up. */
function onKey(event) {
  const rows = [...event.currentTarget.querySelectorAll('.filerow')];
  const at = rows.indexOf(document.activeElement);
  const isText = event.target.type === 'search';
  const to = {
    ArrowDown: at + 1,
    ArrowUp: at - 1,
    ...(isText ? {} : { Home: 0, End: rows.length - 1 }),
  }[event.key];
  if (to !== undefined && rows.length && !event.altKey) {
    event.preventDefault();
    rows[clamp(to, 0, rows.length - 1)].focus();
  } else if (event.key === 'Enter' && isText) rows[0]?.click();
  else if (
    (event.key === 'Backspace' && !(isText && event.target.value)) ||
    (event.key === 'ArrowUp' && event.altKey)
  ) {
    event.preventDefault();
    up();
  }
}
