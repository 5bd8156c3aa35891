// The four views: picture, grid, viser's canvas and room for handles, in one place each. A view
// says where a point of the camera frame is on the screen and back; its window can be moved.

import { html, nothing, render, svg } from './vendor/lit-html/lit-html.js';
import { icon } from './icons.js';
import { S, U, put, watch } from './state.js';
import { aim, cameraEye, parallelEye } from './views/cameras.js';
import { mountFrames } from './views/frames.js';
import { gridLines, scaleBar } from './views/grid.js';
import { Picture } from './views/iframe.js';
import { mountLayout } from './views/layout.js';
import { mountPace, rest } from './views/pace.js';
import { Window } from './views/windows.js';

export { showFrame, shownFrame } from './views/frames.js';

export const VIEWS = ['main', 'top', 'side', 'front'];

const LABELS = { main: 'Camera', top: 'Top', side: 'Side', front: 'Front' };
const GREATEST_PICTURE_SCALE = 64;
const METRE_SCALES = [4, 20000];
/** How far the body reaches beyond its joints. */
const FLESH_M = 0.1;
const LARGE_PX = 420;
const PATIENCE_MS = 1200;
const USUAL_BOX = [-1.2, -1.2, 1.2, 1.2];

const views = new Map();
const listeners = new Set();
const moved = new Set();
let asked = false;

/** The view of this name. */
export function view(name) {
  return views.get(name);
}

/** Call fn(names) once per animation frame after windows, cameras or sizes of these changed. */
export function onViews(fn) {
  listeners.add(fn);
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

let begun = false;

/** viser's pages are large: the first picture of the film goes before them. */
function begin() {
  if (begun) return;
  begun = true;
  for (const each of views.values()) each.begin();
}

class View {
  window = new Window();
  under = layer('under');
  over = layer('over');
  eye = null;
  #paper = layer('paper');
  #marks = Object.assign(document.createElement('div'), { className: 'marks' });
  #picture;

  constructor(el) {
    this.el = el;
    this.name = el.dataset.view;
    this.#picture = new Picture(this.name, {
      aim: (camera) => this.#aim(camera),
      ready: () => el.classList.add('drawn'),
      rest: () => (this.isInLargePlace || el.matches(':hover') ? 0 : rest()),
    });
    el.prepend(this.#paper, this.under, this.#picture.element, this.over, this.#marks);
    new ResizeObserver(() => this.resized()).observe(el);
  }

  begin() {
    this.#picture.load();
  }

  /** Screen pixels in the view, and the distance along its line of sight. */
  project(p) {
    const [a, b, depth] = this.eye.project(p);
    return [...this.window.fromPlane([a, b]), depth];
  }

  toView(screen) {
    return this.window.toPlane(screen);
  }

  fromView(at) {
    return this.window.fromPlane(at);
  }

  pxPerMetre(p) {
    return this.eye.unitsPerMetre(p) * this.window.scale;
  }

  zoomAt(x, y, factor) {
    this.window.zoomAt(x, y, factor);
    this.changed();
  }

  panBy(dx, dy) {
    this.window.panBy(dx, dy);
    this.changed();
  }

  /** Back to the window that shows all there is. */
  fit() {
    this.showAll();
    this.changed();
  }

  /** Draw anew with the next animation frame. */
  changed() {
    this.#picture.redraw(); // asked for now, so that it comes in the same frame as the rest
    moved.add(this);
    if (asked) return;
    asked = true;
    requestAnimationFrame(drawMoved);
  }

  resized() {
    const { clientWidth: width, clientHeight: height } = this.el;
    if (!width || !height) return;
    this.window.resize(width, height);
    if (!this.window.chosen && !U.dragging) this.showAll();
    if (this.eye) this.#picture.resize(width, height);
    this.changed();
  }

  draw() {
    render(this.eye ? this.paper() : nothing, this.#paper);
    render(this.marks(), this.#marks);
  }

  get isLarge() {
    return this.el.clientHeight >= LARGE_PX;
  }

  get isInLargePlace() {
    return this.name === (VIEWS.includes(U.layout) ? U.layout : 'main');
  }

  label(plate = '') {
    if (this.isInLargePlace) return nothing;
    const key = VIEWS.indexOf(this.name) + 1;
    return html`<div class="lab ${plate}"><kbd>${key}</kbd>${LABELS[this.name]}</div>
      <button
        class="ib s exp"
        title="Enlarge   ${key}"
        aria-label="Enlarge ${LABELS[this.name]}"
        @click=${() => put('layout', this.name)}
      >
        ${icon('grow')}
      </button>`;
  }

  #aim(camera) {
    if (this.eye) aim(camera, this.eye, this.window);
  }
}

/** The camera's view: the film, and the body over it. */
class CameraView extends View {
  screen = Object.assign(document.createElement('canvas'), { className: 'vid' });

  constructor(el) {
    super(el);
    this.screen.setAttribute('role', 'img');
    this.screen.ariaLabel = 'Picture of the video';
    el.prepend(this.screen);
  }

  newEye() {
    this.eye = S.camera && cameraEye(S.camera);
    if (S.camera && !this.window.chosen && !U.dragging) this.showAll();
    this.resized();
  }

  follow() {}

  showAll() {
    if (!S.camera) return;
    this.window.showBox([-0.5, -0.5, S.camera.width - 0.5, S.camera.height - 0.5]);
    this.window.limit(Math.min(0.1, this.window.scale / 2), GREATEST_PICTURE_SCALE);
  }

  draw() {
    super.draw();
    if (!S.camera) return;
    const [x, y] = this.window.fromPlane([-0.5, -0.5]);
    const across = (this.window.scale * S.camera.width) / this.screen.width;
    const down = (this.window.scale * S.camera.height) / this.screen.height;
    this.screen.style.transform = `translate(${x}px,${y}px) scale(${across},${down})`;
    this.screen.style.imageRendering = across >= 6 ? 'pixelated' : 'auto';
  }

  paper() {
    const [x, y] = this.window.fromPlane([-0.5, -0.5]);
    const [width, height] = [S.camera.width, S.camera.height].map((n) => n * this.window.scale);
    return svg`<rect class="edge" x=${x} y=${y} width=${width} height=${height} />`;
  }

  marks() {
    return this.label('plate');
  }
}

/** The body from above, from the side or from the front, on squared paper. */
class SideView extends View {
  constructor(el) {
    super(el);
    this.window.limit(...METRE_SCALES);
  }

  newEye() {
    const points = S.pose ? Object.values(S.pose.points) : [];
    this.eye = parallelEye(this.name, S.views, middleOf(points));
    this.resized();
  }

  /** Keep the body in sight, but never move under a hand. */
  follow() {
    if (!S.pose || U.dragging) return;
    if (!this.eye) this.newEye();
    const box = this.bodyBox();
    if (this.window.chosen ? this.window.touches(box) : this.window.holds(box)) return;
    this.showAll(this.window.scale); // no nearer than before: a walking body must not pulse
    this.changed();
  }

  showAll(greatestScale = Infinity) {
    const room = this.isLarge ? { x: 72, top: 64, bottom: 64 } : { x: 8, top: 26, bottom: 20 };
    this.window.showBox(this.bodyBox() ?? USUAL_BOX, room, greatestScale);
  }

  /** The stretch [left, top, right, bottom] of the plane that the body takes. */
  bodyBox() {
    if (!S.pose || !this.eye) return null;
    const points = Object.values(S.pose.points).map(this.eye.project);
    const across = points.map((p) => p[0]);
    const down = points.map((p) => p[1]);
    return [
      Math.min(...across) - FLESH_M,
      Math.min(...down) - FLESH_M,
      Math.max(...across) + FLESH_M,
      Math.max(...down) + FLESH_M,
    ];
  }

  paper() {
    return svg`${gridLines(this.window)}${this.cameraSign()}`;
  }

  /** Where the camera stands, at the border it lies beyond. */
  cameraSign() {
    const { width, height } = this.window;
    if (this.name === 'front') return nothing;
    const below = `${this.isInLargePlace ? width / 2 : width - 16} ${height - 14}`;
    const at = this.name === 'top' ? below : `14 ${height / 2}`;
    const turn = this.name === 'top' ? -90 : 0;
    return svg`<g class="camera" transform="translate(${at}) rotate(${turn})">
      <rect x="-5.5" y="-4" width="8" height="8" rx="1.5" />
      <path d="M2.5-1.5 6.5-4v8L2.500 1.500" /></g>`;
  }

  marks() {
    const bar = scaleBar(this.window);
    return html`${this.label()}
      <div class="scale"><i style="width:${bar.pixels}px"></i>${bar.words}</div>`;
  }
}

let filePath = null;

/** Another film: every window shows all there is. */
function newFile() {
  document.documentElement.classList.toggle('no-file', !S.file);
  const path = S.file?.path ?? null;
  if (path === filePath) return;
  filePath = path;
  for (const each of views.values()) each.fit();
}

function drawMoved() {
  asked = false;
  const now = [...moved];
  moved.clear();
  for (const each of now) each.draw();
  const names = now.map((each) => each.name);
  for (const fn of listeners) fn(names);
}

function middleOf(points) {
  const sum = points.reduce((a, p) => [a[0] + p[0], a[1] + p[1], a[2] + p[2]], [0, 0, 0]);
  return sum.map((total) => total / (points.length || 1));
}

function layer(name) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  element.setAttribute('class', name);
  return element;
}
