// The file button of the top bar: what is open, where it lies, and the way to another one.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { menuItem } from '../actions/buttons.js';
import { icon } from '../controls/icons.js';
import { server, ui } from '../store/state.js';
import { damagedFrames } from '../store/clip.js';
import { isSurface } from '../store/subject.js';
import { isRenamed, renameBox, sessionEntries } from '../start/session_menu.js';
import { heading, line, menuButton, menuHolder, note, toggleMenu } from '../controls/menu.js';
import { loadLibrary } from '../store/library.js';
import { count, longAgo } from '../controls/words.js';

const RECENT = 5;

export function fileButton() {
  const { id, name, path, video } = server.file;
  if (isRenamed(id)) return html`<span class="row file">${icon('film')}${renameBox({ id, name })}</span>`;
  const face = html`${icon('film')}<span class="b cut">${name}</span> <span class="mut wide cut">${video}</span>${icon('chev')}`;
  const button = menuButton('file', { kind: 'row file', title: path, face, act: show });
  return menuHolder('file', () => button, items, 'left filemenu');
}

function show() {
  loadLibrary();
  toggleMenu('file');
}

function items() {
  const others = (ui.library?.recents ?? []).filter((r) => r.path !== server.file.path && !r.missing);
  return [
    menuItem('openFile'),
    menuItem('importFile', undefined, { right: 'motion, keypoints, camera' }),
    ...(others.length ? [heading('Recent'), ...others.slice(0, RECENT).map(recent)] : []),
    line,
    note(facts()),
    ...sessionEntries(server.file).map((entry) => ({ ...entry, right: '' })),
    menuItem('copyPath'),
    line,
    menuItem('closeFile', undefined, { right: 'to the start screen' }),
  ];
}

function recent(session) {
  const { keyframes, opened_at: at } = session;
  return menuItem('openRecent', session, { right: `${count(keyframes, 'keyframe')} · ${longAgo(at)}` });
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
