// One view: picture, paper, viser's canvas and room for handles, in one place. Where pictures come
// late, the view that is looked at draws first, and the others less often. It says where a point of
// the camera frame is on the screen and back; its window can be moved.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { largeFilm } from '../store/films.js';
import { setUi, ui, watch } from '../store/state.js';
import { aim } from './cameras.js';
import { Picture } from './iframe.js';
import { drawsBy } from './software.js';
import { Window } from './windows.js';

const SLOW_MS = 24;
const REST_MS = 250;
/** Software draws what is not looked at so seldom while the film plays: each picture costs it one of the film. */
const PLAYING_REST_MS = 500;
const SETTLED_MS = 120;
/** A step to another frame is measured so long. */
const STEP_MS = 400;

let late = 0;
let last = 0;
let measuring = false;
let stepped = -Infinity;

export function mountPace() {
  watch(['u:playing', 'u:dragging'], begin);
  watch(['view'], () => {
    stepped = performance.now();
    begin();
  });
}

/**
 * When a view draws, in milliseconds: how long it rests between two pictures, how far it stays
 * behind what asks for one, how long after the last wish it draws once more, and whether it draws
 * only once what came at once.
 */
export function pace(isLookedAt) {
  const settled = Math.max(SETTLED_MS, 4 * late);
  const isSoft = drawsBy() === 'software';
  const once = isSoft || late > SLOW_MS;
  const waits = once && !isLookedAt;
  return {
    rest: waits ? (isSoft && ui.playing ? PLAYING_REST_MS : REST_MS) : 0,
    behind: waits ? 2 * late : 0,
    settled,
    once,
  };
}

function begin() {
  if (measuring || !isBusy()) return;
  measuring = true;
  last = 0;
  requestAnimationFrame(measure);
}

function isBusy() {
  return ui.playing || ui.dragging || performance.now() - stepped < STEP_MS;
}

function measure(now) {
  if (last) late += 0.2 * (Math.min(now - last, 500) - late);
  last = now;
  measuring = isBusy();
  if (measuring) requestAnimationFrame(measure);
}

export const VIEWS = ['main', 'top', 'side', 'front'];

/** With the free one, which is shown in the large place only, and another film's, which stands beside that. */
export const ALL_VIEWS = [...VIEWS, 'free', 'film'];

export const VIEW_NAMES = {
  main: 'Camera',
  top: 'Top',
  side: 'Side',
  front: 'Front',
  free: 'Free',
  film: 'Other film',
};
export const VIEW_KEYS = { main: '1', top: '2', side: '3', front: '4', free: '6' };
const LARGE_PX = 420;

/** @type {WeakMap<Element, View>} */
const views = new WeakMap();
/** @type {ResizeObserver | null} made with the first view: the module also loads without a browser */
let sizes = null;
const listeners = new Set();
const moved = new Set();
let asked = false;

/** Call fn(names) once per animation frame after windows, cameras or sizes of these changed. */
export function onViews(fn) {
  listeners.add(fn);
}

export class View {
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
      pace: () => pace(this.isInLargePlace || el.matches(':hover')),
      isHidden: () => !this.isShown || this.isPainted,
    });
    el.prepend(this.#paper, this.under, this.over, this.#marks);
    watchSize(this);
  }

  /** Fetch viser's page and show its picture. */
  begin() {
    this.over.before(this.#picture.element);
    if (this.eye) this.fitToSize();
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
    this.redraw();
  }

  panBy(dx, dy) {
    this.window.panBy(dx, dy);
    this.redraw();
  }

  /** Back to the window that shows all there is. */
  fit() {
    this.showAll();
    this.redraw();
  }

  /** Draw anew with the next animation frame. */
  redraw() {
    if (!this.isShown) return;
    this.#picture.redraw(); // asked for now, so that it comes in the same frame as the rest
    moved.add(this);
    if (asked) return;
    asked = true;
    requestAnimationFrame(drawMoved);
  }

  fitToSize() {
    const { clientWidth: width, clientHeight: height } = this.el;
    if (!width || !height) return;
    this.window.resize(width, height);
    if (!this.window.chosen && !ui.dragging) this.showAll();
    if (this.eye) this.#picture.resize(width, height);
    this.redraw();
  }

  draw() {
    render(this.eye ? this.paper() : nothing, this.#paper);
    render(this.marks(), this.#marks);
  }

  /** The window that shows all there is. */
  showAll() {}

  /** What lies below the body. */
  paper() {
    return nothing;
  }

  /** What is written over it. */
  marks() {
    return nothing;
  }

  get isLarge() {
    return this.window.height >= LARGE_PX;
  }

  get isInLargePlace() {
    return this.name === (ALL_VIEWS.includes(ui.layout) ? ui.layout : 'main');
  }

  /** The free view takes the place of the top one, and another film's that of all small ones. */
  get isShown() {
    if (largeFilm()) return this.isInLargePlace;
    return this.name !== (ui.layout === 'free' ? 'top' : 'free');
  }

  /** Whether the page paints the body in it, in the place of viser's picture. */
  get isPainted() {
    return false;
  }

  /** What goes with a message about a place in this view. */
  inMessage() {
    return { view: this.name };
  }

  /** The view's name and the button that enlarges it; none in the large place. plate: a class of the style. */
  label(plate = '') {
    if (this.isInLargePlace) return nothing;
    const key = VIEW_KEYS[this.name];
    return html`<div class="row lab ${plate}" title="Double-click for the free view"
      @dblclick=${() => setUi('layout', 'free')}><kbd>${key}</kbd>${VIEW_NAMES[this.name]}</div>
      <button
        class="ib s exp"
        title="Enlarge" data-key=${key}
        aria-label="Enlarge ${VIEW_NAMES[this.name]}"
        @click=${() => setUi('layout', this.name)}
      >
        ${icon('grow')}
      </button>`;
  }

  #aim(camera) {
    if (this.eye) aim(camera, this.eye, this.window);
  }
}

/** Views of a new size are drawn before the browser shows it: handles and picture stay together. @param {View} view */
function watchSize(view) {
  sizes ??= new ResizeObserver((entries) => {
    for (const { target } of entries) views.get(target).fitToSize();
    drawMoved();
  });
  views.set(view.el, view);
  sizes.observe(view.el);
}

function drawMoved() {
  asked = false;
  if (moved.size === 0) return;
  const now = [...moved];
  moved.clear();
  for (const each of now) each.draw();
  const names = now.map((each) => each.name);
  for (const fn of listeners) fn(names);
}

function layer(name) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  element.setAttribute('class', name);
  return element;
}
