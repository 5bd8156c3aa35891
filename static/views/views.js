// The four views: the rest of the page finds them here.

import { server, setUi, watch } from '../store/state.js';
import { CameraView } from './cameraview.js';
import { mountFrames } from './frames.js';
import { mountLayout } from './layout.js';
import { mountPace } from './pace.js';
import { SideView } from './sideview.js';

export { showFrame, shownFrame } from './frames.js';
export { VIEWS, onViews } from './view.js';

const PATIENCE_MS = 1200;

const views = new Map();
let begun = false;
let filePath = null;

/** The view of this name. */
export function view(name) {
  return views.get(name);
}

export function mount() {
  for (const el of document.querySelectorAll('.view')) {
    const made = el.dataset.view === 'main' ? new CameraView(el) : new SideView(el);
    views.set(made.name, made);
  }
  mountLayout();
  mountPace();
  mountFrames(view('main').screen, () => {
    view('main').changed();
    begin();
  });
  setTimeout(begin, PATIENCE_MS);
  watch(['file'], newFile);
  watch(['camera', 'views'], () => views.forEach((each) => each.newEye()));
  watch(['pose'], () => views.forEach((each) => each.follow()));
  watch(['u:layout'], () => views.forEach((each) => each.changed()));
}

/** viser's pages are large: the first picture of the film goes before them. */
function begin() {
  if (begun) return;
  begun = true;
  if (!draws3D()) return setUi('flat', true);
  for (const each of views.values()) each.begin();
}

/** Another film: every window shows all there is. */
function newFile() {
  document.documentElement.classList.toggle('no-file', !server.file);
  const path = server.file?.path ?? null;
  if (path === filePath) return;
  filePath = path;
  for (const each of views.values()) each.fit();
}

/** Some browsers draw no 3D at all, most often for want of a graphics card. */
function draws3D() {
  return Boolean(document.createElement('canvas').getContext('webgl2'));
}
