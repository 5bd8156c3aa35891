// The views: the rest of the page finds them here.

import { server, setUi, ui, watch } from '../store/state.js';
import { CameraView } from './cameraview.js';
import { mountFigure } from './figure.js';
import { FilmView } from './filmview.js';
import { FreeView } from './freeview.js';
import { isPictureOf, mountFrames } from './frames.js';
import { mountPersonMask } from './person_mask.js';
import { mountLayout, showLarge } from './layout.js';
import { ALL_VIEWS, mountPace, onViews, VIEW_KEYS, VIEW_NAMES, VIEWS } from './view.js';
import { SideView } from './sideview.js';
import { drawsBy } from './software.js';

export { ALL_VIEWS, isPictureOf, onViews, showLarge, VIEW_KEYS, VIEW_NAMES, VIEWS };

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
    const made = madeFor(el);
    views.set(made.name, made);
  }
  mountFigure();
  mountLayout();
  mountPace();
  mountFrames(view('main').screen, () => {
    view('main').redraw();
    begin();
  });
  mountPersonMask(view('main').person, () => view('main').redraw());
  setTimeout(begin, PATIENCE_MS);
  watch(['file'], newFile);
  watch(['camera', 'views', 'camera_here', 'camera_motion'], () => views.forEach((each) => each.newEye()));
  watch(['pose'], () => views.forEach((each) => each.follow()));
  watch(['feet', 'keys'], () => ['main', 'side', 'front'].forEach((name) => view(name).redraw()));
  watch(['view'], () => view('main').follow());
  watch(['body', 'solids', 'ghosts', 'before', 'trail', 'poses_beside', 'solids_beside'], () => view('main').paint());
  watch(['u:painted'], () => {
    if (begun) beginShown();
    view('main').redraw();
  });
  watch(['films', 'u:filmLarge', 'u:layout'], () => {
    if (begun) beginShown();
    views.forEach((each) => each.redraw());
  });
}

function madeFor(el) {
  if (el.dataset.view === 'main') return new CameraView(el);
  if (el.dataset.view === 'film') return new FilmView(el);
  return el.dataset.view === 'free' ? new FreeView(el, view('main').screen) : new SideView(el);
}

/** Fit the picture of what is large. */
export function fitLarge() {
  for (const name of ui.layout === 'quad' ? VIEWS : [ui.layout, 'film']) view(name)?.fit();
}

/** viser's pages are large: the first picture of the film goes before them. */
function begin() {
  if (begun) return;
  begun = true;
  if (drawsBy() === 'none') return setUi('flat', true);
  beginShown();
}

const fetched = new Set();

/** Those that are shown for the first time fetch viser's page. */
function beginShown() {
  if (ui.flat) return;
  for (const each of views.values()) {
    if (!each.isShown || each.isPainted || fetched.has(each)) continue;
    fetched.add(each);
    each.begin();
  }
}

/** Another film: every window shows all there is. */
function newFile() {
  document.documentElement.classList.toggle('no-file', !server.file);
  const path = server.file?.path ?? null;
  if (path === filePath) return;
  filePath = path;
  for (const each of views.values()) each.fit();
}
