// The picture of another film at the present moment, and over it the body as its camera sees it.

import { server, ui } from '../store/state.js';
import { fetchOwn } from '../store/storage.js';
import { cameraEye } from './cameras.js';
import { paintBody } from './figure.js';
import { placed } from './floor.js';
import { sightSeen } from './sight.js';

/** @typedef {import('../store/shapes.js').Film} Film */
/** @typedef {{ at: number | undefined, T: number[], parts: Record<string, number[]> | undefined }} Moment */

/** What pictures that are kept of a film take, and so many are kept anyway. */
const MOST_BYTES = 200e6;
const LEAST_KEPT = 48;
/** Moments of which it is remembered how the body stood: a picture may come a little later. */
const MOST_MOMENTS = 120;
/** Pictures that are fetched at a time. */
const MOST_LOADS = 3;
/** Which pictures are fetched, from the present one on. */
const BESIDE = [0, 1, 2, -1, 3];
/** The same while the film plays: what is fetched now is seen a little later, and not every frame is. */
const AHEAD = [2, 4, 7, 10, 14, 18];
const SHRINKS = [4, 2];
const SIGHT_PX = 1.3;
const SIGHT_DASHES = [2, 3];

/** @param {CanvasRenderingContext2D} ctx @param {number[][]} line */
function paintSight(ctx, line) {
  if (!line.length) return;
  ctx.strokeStyle = getComputedStyle(ctx.canvas).getPropertyValue('--acc');
  ctx.lineWidth = SIGHT_PX;
  ctx.setLineDash(SIGHT_DASHES);
  ctx.beginPath();
  for (const [x, y] of line) ctx.lineTo(x, y);
  ctx.stroke();
  ctx.setLineDash([]);
}

export class FilmPicture {
  picture = Object.assign(document.createElement('canvas'), { className: 'vid' });
  figure = Object.assign(document.createElement('canvas'), { className: 'figure' });
  /** Why there is no picture, a sentence. */
  why = '';

  /** @type {Film} */
  #film;
  #version = '';
  /** @type {Map<number, ImageBitmap>} */
  #decoded = new Map();
  #loading = new Set();
  /** How the body stood when a frame of the film was to be seen. @type {Map<number, Moment>} */
  #moments = new Map();
  #changed;
  #window;
  #sizes = new ResizeObserver(() => this.paint());

  /**
   * @param {() => void} changed  Called when it is known why there is no picture, or when one has another size.
   * @param {import('./windows.js').Window | null} window  Of the view it is shown in; else it fills its place.
   */
  constructor(changed, window = null) {
    this.#changed = changed;
    this.#window = window;
    this.picture.setAttribute('role', 'img');
    this.#sizes.observe(this.figure);
  }

  /** Show what a film shows now. @param {Film} film */
  follow(film) {
    this.#film = film;
    this.#remember();
    this.picture.ariaLabel = `Picture of ${film.name}`;
    this.#show();
    this.paint();
  }

  #remember() {
    const { frame, T } = this.#film;
    if (frame === null || !server.pose) return;
    this.#moments.delete(frame); // the newest stand last
    this.#moments.set(frame, { at: server.pose.frame, T, parts: server.pose.T });
    if (this.#moments.size > MOST_MOMENTS) this.#moments.delete(this.#moments.keys().next().value);
  }

  /** The moment of the picture that is shown, while the film plays; else the present one. */
  get #moment() {
    const shown = Number(this.picture.dataset.frame);
    const frames = ui.playing ? [...this.#moments.keys()] : [];
    const [near] = frames.sort((one, other) => Math.abs(one - shown) - Math.abs(other - shown));
    const moment = this.#moments.get(near);
    return moment ?? { at: server.pose?.frame, T: this.#film.T, parts: server.pose?.T };
  }

  /** Forget all pictures, until there is again something to show. */
  rest() {
    this.#film = null;
    this.#forget('');
  }

  /** Forget all pictures for good. */
  close() {
    this.#sizes.disconnect();
    this.rest();
  }

  /** Paint the body as it stands now. */
  paint() {
    if (!this.#film) return;
    const { clientWidth: across, clientHeight: down } = this.figure;
    const [width, height] = [across, down].map((px) => Math.round(px * devicePixelRatio));
    if (!width || !height) return;
    this.#show(); // in another size it may need more pixels
    if (this.figure.width !== width || this.figure.height !== height) Object.assign(this.figure, { width, height });
    const ctx = this.figure.getContext('2d');
    const { camera, frame } = this.#film;
    const { at, T, parts } = this.#moment;
    ctx.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    ctx.clearRect(0, 0, across, down);
    const eye = cameraEye(camera);
    const project = (p) => {
      const [u, v, depth] = eye.project(p);
      return [...this.#onScreen([u, v]), depth];
    };
    const isThere = frame !== null && paintBody(ctx, project, T, parts, camera.projection === 'telephoto');
    if (isThere) this.figure.dataset.frame = String(at);
    else delete this.figure.dataset.frame;
    if (!this.#window) {
      paintSight(
        ctx,
        sightSeen((p) => project(placed([p], T)[0])),
      );
    }
  }

  /** Where a pixel of the film is shown. */
  #onScreen([u, v]) {
    if (this.#window) return this.#window.fromPlane([u, v]);
    return [(u + 0.5) * this.#scale, (v + 0.5) * this.#scale];
  }

  /** Pixels of the page to one of the film. */
  get #scale() {
    return this.#window?.scale ?? (this.figure.clientWidth || 1) / this.#film.camera.width;
  }

  #show() {
    const address = this.#address(0);
    if (address !== this.#version) this.#forget(address);
    const { frame } = this.#film;
    if (frame === null) return this.#blank('');
    const near = this.#nearest(frame);
    if (near !== null) this.#draw(near, this.#decoded.get(near));
    this.#load();
  }

  /** The frame whose picture is shown for this one: its own, or while the film plays the nearest that is there. */
  #nearest(frame) {
    if (this.#decoded.has(frame)) return frame;
    if (!ui.playing || !this.#decoded.size) return null;
    const away = (each) => Math.abs(each - frame);
    return [...this.#decoded.keys()].reduce((best, each) => (away(each) < away(best) ? each : best));
  }

  /** Where a frame's picture comes from, with as many pixels as are seen. */
  #address(frame) {
    const { id, image_version: version } = this.#film;
    const shrink = SHRINKS.find((by) => by * this.#scale * devicePixelRatio <= 1) ?? 1;
    return `/film/${encodeURIComponent(id)}/${frame}.jpg?v=${encodeURIComponent(version)}&shrink=${shrink}`;
  }

  #forget(version) {
    for (const bitmap of this.#decoded.values()) bitmap.close();
    this.#decoded.clear();
    this.#loading.clear();
    this.#version = version;
  }

  #blank(why) {
    delete this.picture.dataset.frame;
    if (why === this.why) return;
    this.why = why;
    this.#changed();
  }

  #draw(frame, bitmap) {
    this.#decoded.delete(frame); // the newest used stand last
    this.#decoded.set(frame, bitmap);
    const isSameSize = this.picture.width === bitmap.width;
    if (this.picture.dataset.frame === String(frame) && isSameSize) return;
    Object.assign(this.picture, { width: bitmap.width, height: bitmap.height });
    this.picture.getContext('2d').drawImage(bitmap, 0, 0);
    this.picture.dataset.frame = String(frame);
    if (isSameSize && !this.why) return;
    this.why = '';
    this.#changed();
  }

  /** Fetch the present picture, and then those beside it. */
  #load() {
    const { frame, frames } = this.#film;
    if (frame === null) return;
    const way = Math.sign(ui.shuttle);
    const late = Math.max(0, way * (frame - Number(this.picture.dataset.frame ?? frame)));
    const steps = ui.playing ? AHEAD.map((step) => way * (step + late)) : this.why ? [0] : BESIDE;
    for (const each of steps.map((step) => frame + step)) {
      if (this.#loading.size >= MOST_LOADS) return;
      if (each >= 0 && each < frames && !this.#decoded.has(each) && !this.#loading.has(each)) this.#fetch(each);
    }
  }

  async #fetch(frame) {
    const version = this.#version;
    this.#loading.add(frame);
    let isThere = false;
    try {
      const answer = await fetchOwn(this.#address(frame));
      const bitmap = answer.ok ? await createImageBitmap(await answer.blob()) : null;
      const words = answer.ok ? '' : (await answer.text()).trim();
      if (version !== this.#version) return void bitmap?.close();
      isThere = bitmap !== null;
      if (bitmap) this.#keep(frame, bitmap);
      else if (frame === this.#film.frame) this.#blank(words);
    } catch {
      // The connection is lost, which is said elsewhere.
    } finally {
      if (version === this.#version) this.#loading.delete(frame);
    }
    if (isThere) this.#load();
  }

  #keep(frame, bitmap) {
    this.#decoded.set(frame, bitmap);
    const most = Math.max(LEAST_KEPT, MOST_BYTES / (4 * bitmap.width * bitmap.height));
    for (const [each, old] of this.#decoded) {
      if (this.#decoded.size <= most) break;
      if (each === this.#film.frame) continue;
      this.#decoded.delete(each);
      old.close();
    }
    if (this.#film.frame === null || this.#nearest(this.#film.frame) !== frame) return;
    this.#draw(frame, bitmap);
    if (ui.playing) this.paint(); // the body as it stood then
  }
}
