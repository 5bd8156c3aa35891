// The file button of the top bar: what is open, where it lies, and the way to another one.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { send } from '../store/link.js';
import { server, ui } from '../store/state.js';
import { damagedFrames } from '../store/damage.js';
import { isSurface } from '../store/subject.js';
import { heading, line, menuHolder, note, toggleMenu } from '../controls/menu.js';
import { openChooser } from '../start/chooser.js';
import { loadLibrary } from '../start/library.js';
import { toast } from '../controls/toasts.js';
import { count, longAgo } from '../controls/words.js';

const RECENT = 5;

export function fileButton() {
  const button = (open) => html`<button
    class="row file ${open ? 'hov' : ''}"
    aria-haspopup="menu"
    aria-expanded=${open}
    title=${server.file.path ?? nothing}
    @click=${show}
  >
    ${icon('film')}<span class="b cut">${server.file.name}</span>
    <span class="mut wide cut">${server.file.video}</span>${icon('chev')}
  </button>`;
  return menuHolder('file', button, items, 'left filemenu');
}

function show() {
  loadLibrary();
  toggleMenu('file');
}

function items() {
  const others = (ui.library?.recents ?? []).filter((r) => r.path !== server.file.path && !r.missing);
  return [
    { icon: 'folder', label: 'Open another…', run: () => openChooser('any') },
    ...(others.length ? [heading('Recent'), ...others.slice(0, RECENT).map(recent)] : []),
    line,
    note(facts()),
    { icon: 'copy', label: 'Copy the path', run: copyPath },
    line,
    { icon: 'x', label: 'Close', right: 'to the start screen', run: () => send({ do: 'close' }) },
  ];
}

function recent({ id, name, keyframes, opened_at: at }) {
  return {
    icon: 'film',
    label: name,
    right: `${count(keyframes, 'keyframe')} · ${longAgo(at)}`,
    run: () => send({ do: 'open', kind: 'recent', id }),
  };
}

function facts() {
  const { frames, fps, width, height, duration_s: seconds, path, missing } = server.file;
  const lost = isSurface() ? missing.length : damagedFrames();
  const rate = Number.isInteger(fps) ? fps : fps?.toFixed(2);
  return html`<span class="num">${count(frames, 'frame')} · ${rate} fps · ${width} × ${height}</span>
    <span class="num"> · ${seconds?.toFixed(2)} s</span>
    ${lost ? html`<br /><span class="checkword">${damaged(lost)}</span>` : nothing}
    <br /><span class="path">${path}</span>`;
}

const damaged = (n) =>
  isSurface() ? `${count(n, 'step')} without a surface` : `${count(n, 'damaged frame')}, not used for tracking`;

async function copyPath() {
  try {
    await navigator.clipboard.writeText(server.file.path);
    toast({ kind: 'good', words: 'Path copied.' });
  } catch {
    toast({ kind: 'info', words: server.file.path });
  }
}
