// The free view: the body on its floor from anywhere, with the film's camera and its picture. It
// is turned with the right button, the middle one or Alt; where one looked is kept for every film.

import { html, nothing, render, svg } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { inBrowser } from '../store/storage.js';
import { onto } from './floor.js';
import {
  bodyMiddle,
  drawCameraPath,
  drawFilmCamera,
  drawFloor,
  drawGhosts,
  drawShadow,
  drawWays,
  filmCamera,
  filmWords,
  ghostLabels,
  ground,
  hasBody,
  toCamera,
  wayKeys,
  wayLabels,
} from './freescene.js';
import {
  aboveFloor,
  alongAxis,
  between,
  dollied,
  FOCAL,
  framing,
  freeEye,
  isEye,
  orbited,
  panned,
  placeOf,
  rowsOf,
} from './orbit.js';
import { View } from './view.js';
import { moved, movedBack } from './world.js';

/** Of the shorter side of the view: an angle of view of 37°, as in exported pictures. */
const FOCAL_SHARE = 1.5;
const DEGREES_PER_PX = 0.35;
const USUAL = { azimuth: 52, elevation: 20 };
/** The film's camera is part of what a reset shows, as far as the eye needs no more than so many times
 * the distance for it: the body stays large. */
const BACK_FOR_CAMERA = 1.6;
const MARGIN = 0.82;
const TURN_DEG_PER_S = 24;
/** The eye follows a body as if by a rope: so much of the way in a picture while playing. */
const FOLLOW_SHARE = 0.12;
const KEPT_MS = 300;
const PICTURE_PX = 640;
/** The camera is named where its picture's words are so far away. */
const APART_PX = 120;
/** Frame numbers nearer to each other than this cannot be read. */
const LABEL_PX = 18;
const AXES_PX = 24;

/** How one orbits, of every film: about what, and whether the eye follows or turns by itself. */
const HABITS = { about: 'part', follows: false, turns: false, camera: true };

export class FreeView extends View {
  habits = { ...HABITS };
  state = null;
  #source;
  #film = Object.assign(document.createElement('canvas'), { className: 'film' });
  #kept = null;
  #root = null;
  #keeping = 0;

  /** @param {HTMLElement} el  @param {HTMLCanvasElement} source  The film's picture. */
  constructor(el, source) {
    super(el);
    this.#source = source;
    this.under.before(this.#film);
    this.window.limit(1e-3, 1e3);
    watch(['feet', 'ghosts', 'solids', 'view', 'keys', 'u:shown'], () => (this.state ? this.redraw() : this.newEye()));
    addEventListener('pagehide', () => this.#keep());
    watch(['u:playing', 'u:layout'], () => this.#turn(performance.now()));
  }

  // --- the eye

  newEye() {
    this.#carry();
    const isKnown = server.views && server.camera && server.pose && server.feet;
    if (!isKnown || !this.el.clientWidth) return; // what fits is known once there is a place to fit it into
    this.state ??= this.#read() ?? this.#usual();
    this.#look(this.state, false);
  }

  fitToSize() {
    super.fitToSize();
    if (!this.state) this.newEye();
  }

  /** The eye stands still in the world while the film's camera moves. */
  #carry() {
    const { camera_here: here } = server;
    if (this.state && here !== this.#here) {
      this.state = { ...this.state, target: movedBack(moved(this.state.target, this.#here), here) };
      if (this.#root) this.#root = movedBack(moved(this.#root, this.#here), here);
    }
    this.#here = here;
  }

  /** T_world_camera of the frame that the eye is said for. */
  #here = null;

  /** Another film: what was kept of it, or all there is to see. */
  fit() {
    const id = server.file?.id ?? null;
    if (this.#kept === id) inBrowser.remove(this.#key());
    this.#kept = id;
    clearTimeout(this.#keeping);
    this.#keeping = 0;
    this.#root = this.state = this.eye = null;
    this.#here = server.camera_here;
    this.newEye();
  }

  /** The body moved. */
  follow() {
    this.el.classList.toggle('empty', !hasBody());
    const root = server.pose?.root;
    if (!this.state || !root) return;
    const before = this.#root ?? root;
    this.#root = root;
    if (this.habits.follows && !ui.dragging) {
      const share = ui.playing ? FOLLOW_SHARE : 1;
      this.#behind = this.#behind.map((value, k) => value + root[k] - before[k]);
      const step = this.#behind.map((value) => value * share);
      this.#behind = this.#behind.map((value, k) => value - step[k]);
      this.#look({ ...this.state, target: this.state.target.map((value, k) => value + step[k]) });
    }
    this.redraw();
  }

  /** How far the body is ahead of the eye that follows it. */
  #behind = [0, 0, 0];

  showAll() {
    const { width, height } = this.window;
    this.window.x = this.window.y = 0;
    this.window.scale = (FOCAL_SHARE * Math.min(width, height)) / FOCAL;
  }

  /** The pointer pulls the scene round by so many pixels. */
  orbitBy(dx, dy) {
    this.#orbit(-dx * DEGREES_PER_PX, dy * DEGREES_PER_PX);
    setUi('orbited', true);
  }

  #orbit(azimuth, elevation) {
    if (this.state) this.#look(orbited(this.state, server.views.front, azimuth, elevation, this.#pivot()));
  }

  panBy(dx, dy) {
    if (this.state) this.#look(panned(this.state, server.views.front, dx / this.window.scale, dy / this.window.scale));
  }

  zoomAt(x, y, factor) {
    if (this.state) this.#look(dollied(this.state, server.views.front, factor, this.toView([x, y])));
  }

  /** Look along an axis of the level world: x, y or z. */
  alongAxis(axis) {
    if (this.state) this.#look(alongAxis(this.state, server.views.front, axis, bodyMiddle()));
  }

  /** Set one of the habits. */
  choose(name, value) {
    this.habits = { ...this.habits, [name]: value };
    this.#behind = [0, 0, 0];
    this.#look(this.state);
    this.#turn(performance.now());
  }

  /** What goes with a message about a place in this view. */
  inMessage() {
    const { azimuth, elevation } = this.state;
    const at = placeOf(this.state, server.views.front);
    return { view: this.name, eye: { azimuth_deg: azimuth, elevation_deg: elevation, at_m: at } };
  }

  /** The point that stays where it is while the eye turns. */
  #pivot() {
    const part = this.habits.about === 'part' && server.view?.selected;
    return (part && server.pose?.points[part]) || bodyMiddle();
  }

  #look(state, isNew = true) {
    const { level, floor } = ground() ?? { level: server.views.front, floor: -Infinity };
    this.state = aboveFloor(state, level, floor);
    this.eye = freeEye(this.state, level);
    if (isNew) this.#keepSoon();
    this.fitToSize();
  }

  /** The body, its way, and the camera's picture, from beside. */
  #usual() {
    const level = server.views.front;
    const points = [
      ...Object.values(server.pose?.points ?? {}),
      ...(server.feet?.paths ?? []).flatMap((foot) => foot.points.map(toCamera)),
    ];
    if (!points.length) points.push([-1, -1, 2], [1, 1, 4]);
    const { width, height } = this.window;
    const half = [width, height].map((px) => (MARGIN * px * FOCAL) / (2 * FOCAL_SHARE * Math.min(width, height)));
    const body = framing(USUAL, level, points, half);
    if (!this.habits.camera) return body;
    const all = framing(USUAL, level, [...points, [0, 0, 0], ...filmCamera().corners], half);
    return between(body, all, BACK_FOR_CAMERA * body.distance);
  }

  /** Whether nobody posed the body yet. */
  get isEmpty() {
    return !hasBody();
  }

  // --- kept per film

  #key = () => `keypose.free.${server.file?.id ?? ''}`;

  #read() {
    try {
      const kept = JSON.parse(inBrowser.read(this.#key()) ?? 'null');
      if (!isEye(kept?.eye)) return null;
      const isHabit = ([name, value]) => typeof value === typeof HABITS[name];
      this.habits = { ...HABITS, ...Object.fromEntries(Object.entries(kept.habits ?? {}).filter(isHabit)) };
      return { ...kept.eye, target: movedBack(kept.eye.target, server.camera_here) };
    } catch {
      return null; // what cannot be read is as if it were not there
    }
  }

  #keepSoon() {
    clearTimeout(this.#keeping);
    this.#keeping = setTimeout(() => this.#keep(), KEPT_MS);
  }

  /** Keep what waits to be. */
  #keep() {
    if (!this.#keeping) return;
    clearTimeout(this.#keeping);
    this.#keeping = 0;
    if (!this.state) return;
    const eye = { ...this.state, target: moved(this.state.target, this.#here) };
    inBrowser.write(this.#key(), JSON.stringify({ eye, habits: this.habits }));
  }

  // --- turning by itself

  #turnedAt = 0;
  #isTurning = false;

  #turn(now) {
    if (this.#isTurning || !this.#shouldTurn()) return;
    this.#isTurning = true;
    this.#turnedAt = now;
    requestAnimationFrame((next) => this.#step(next));
  }

  #shouldTurn = () => this.habits.turns && ui.playing && this.isShown;

  #step(now) {
    this.#isTurning = this.#shouldTurn();
    if (!this.#isTurning) return;
    if (!ui.dragging) this.#orbit((Math.max(0, now - this.#turnedAt) / 1000) * TURN_DEG_PER_S, 0);
    this.#turnedAt = now;
    requestAnimationFrame((next) => this.#step(next));
  }

  // --- what is drawn

  #project = (p) => this.project(p);

  draw() {
    if (!this.isShown) return;
    super.draw();
    const isReady = Boolean(this.eye && ground() && server.body && server.view);
    render(isReady ? this.#things() : nothing, this.under);
    this.#drawPicture(isReady);
  }

  paper() {
    if (!ground()) return nothing;
    return svg`${drawFloor(this.#project, this.state.distance)}${drawShadow(this.#project)}`;
  }

  #things() {
    const project = this.#project;
    const hasCamera = this.habits.camera && server.camera;
    return svg`${drawGhosts(project)}${drawWays(project)}${
      hasCamera ? svg`${drawCameraPath(project)}${drawFilmCamera(project)}` : nothing
    }`;
  }

  /** The picture of the film, laid into its frame. */
  #drawPicture(isReady) {
    const corners =
      isReady && this.habits.camera && this.#source.dataset.frame ? filmCamera().corners.map(this.#project) : [];
    const isSeen = corners.length > 0 && corners.every((p) => p[2] > 0.05);
    this.#film.hidden = !isSeen;
    if (!isSeen) return;
    const { width, height } = this.#source;
    const k = Math.min(1, PICTURE_PX / Math.max(width, height));
    const [across, down] = [Math.round(width * k), Math.round(height * k)];
    if (this.#film.width !== across || this.#film.height !== down) {
      Object.assign(this.#film, { width: across, height: down });
    }
    this.#film.getContext('2d').drawImage(this.#source, 0, 0, across, down);
    this.#film.style.transform = onto(corners, across, down);
  }

  /** Keyframes on the feet's ways. */
  trailKeys() {
    return this.eye && ground() ? wayKeys(this.#project) : [];
  }

  marks() {
    if (!this.eye || !ground() || !server.view) return nothing;
    const labels = hasBody() ? apart([...ghostLabels(this.#project), ...wayLabels(this.#project)]) : [];
    return html`${labels.map(label)}${this.#cameraMark()}${this.#axes()}
      ${hasBody() ? nothing : html`<div class="none">Pose a frame to see the body here.</div>`}`;
  }

  #cameraMark() {
    if (!this.habits.camera || !server.camera) return nothing;
    const { place, corners } = filmCamera();
    const [at, corner] = [this.project(place), this.project(corners[3])];
    const isApart = Math.hypot(at[0] - corner[0], at[1] - corner[1]) > APART_PX;
    return html`${
      at[2] > 0.05
        ? html`<button class="eye" title="Camera view" data-key="1" aria-label="Camera view" style=${stand(at)}
            @click=${() => setUi('layout', 'main')}>${icon('camc')}</button>
          ${isApart ? label({ words: 'Camera', at, shift: [16, 1] }) : nothing}`
        : nothing
    }
    ${corner[2] > 0.05 ? label({ words: filmWords(), at: corner, shift: [0, 20], kind: 'faint' }) : nothing}`;
  }

  /** The level world's axes: a click on a letter looks along it. */
  #axes() {
    const level = server.views.front;
    const rows = rowsOf(this.state, level);
    const ways = { x: level[0], y: level[1].map((v) => -v), z: level[2] };
    const ends = Object.entries(ways).map(([axis, way]) => {
      const [x, y, depth] = rows.map((row) => row[0] * way[0] + row[1] * way[1] + row[2] * way[2]);
      return { axis, x: x * AXES_PX, y: y * AXES_PX, depth };
    });
    ends.sort((a, b) => b.depth - a.depth);
    return html`<svg class="axes" viewBox="-34 -34 68 68" role="group" aria-label="Axes">
      <circle class="ground" r="34" />
      ${ends.map(
        ({ axis, x, y }) => svg`<g class=${`axis ${axis}`} role="button" tabindex="0" data-axis=${axis}
        aria-label=${`Look along ${axis.toUpperCase()}`} @click=${() => this.alongAxis(axis)}
        @keydown=${(event) => this.#axisKey(event, axis)}>
        <title>Look along ${axis.toUpperCase()}</title>
        <path d=${`M0 0L${x.toFixed(1)} ${y.toFixed(1)}`} /><circle cx=${x} cy=${y} r="7.5" />
        <text x=${x} y=${y + 3.5}>${axis.toUpperCase()}</text></g>`,
      )}
    </svg>`;
  }

  #axisKey(event, axis) {
    if (event.key !== 'Enter' && event.key !== ' ') return;
    event.preventDefault();
    event.stopPropagation();
    this.alongAxis(axis);
  }
}

/** Without those that would stand on one before them. */
function apart(labels) {
  const place = ({ at, shift }) => [at[0] + shift[0], at[1] + shift[1]];
  return labels.filter((one, i) =>
    labels.slice(0, i).every((other) => {
      const [a, b] = [place(one), place(other)];
      return Math.hypot(a[0] - b[0], a[1] - b[1]) > LABEL_PX;
    }),
  );
}

/** @param {number[]} at */
const stand = ([x, y]) => `left:${x.toFixed(1)}px;top:${y.toFixed(1)}px`;

/** @param {{ words: string, at: number[], shift: number[], kind?: string }} mark */
function label({ words, at, shift: [dx, dy], kind = '' }) {
  return html`<span class="mark num ${kind} ${dx < 0 ? 'left' : ''}"
    style=${stand([at[0] + dx, at[1] + dy])}>${words}</span>`;
}
