// The camera's view: the film, and over it the body, which the page paints where 3D is slow.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { isSurface } from '../store/clip.js';
import { cameraEye } from './cameras.js';
import { dropped, gridPaths } from './floor.js';
import { showAcross } from './frames.js';
import { feetMiddle, ground } from './freescene.js';
import { paintFigure } from './figure.js';
import { View } from './view.js';

export const GREATEST_SCALE = 64;
/** The grid of the floor fades until here. */
const FLOOR_REACH_M = 2;
/** More pixels of the screen to one of the page are not painted. */
const GREATEST_SHARPNESS = 2;
const BARS_PX = 52; // the height of the bars at the top

/** So many pixels of the screen to one of a picture's own show that pixel as it is. */
const PIXELATED = 6;

/**
 * Lay a picture where a camera's picture is in a window.
 * @param {HTMLElement} picture
 * @param {{ width: number, height: number }} camera
 * @param {import('./windows.js').Window} window
 * @param {{ width: number, height: number }} size  Of the picture's own pixels.
 */
export function place(picture, camera, window, size = /** @type {HTMLCanvasElement} */ (picture)) {
  const [x, y] = window.fromPlane([-0.5, -0.5]);
  const across = (window.scale * camera.width) / size.width;
  const down = (window.scale * camera.height) / size.height;
  picture.style.transform = `translate(${x}px,${y}px) scale(${across},${down})`;
  picture.style.imageRendering = across >= PIXELATED ? 'pixelated' : 'auto';
}

export class CameraView extends View {
  screen = Object.assign(document.createElement('canvas'), { className: 'vid' });
  person = Object.assign(document.createElement('img'), { className: 'pmask', alt: '' });

  #figure = Object.assign(document.createElement('canvas'), { className: 'figure' });

  constructor(el) {
    super(el);
    this.screen.setAttribute('role', 'img');
    this.screen.ariaLabel = 'Picture of the video';
    el.prepend(this.screen, this.person);
    this.over.before(this.#figure);
  }

  get isPainted() {
    return Boolean(ui.painted);
  }

  /** The camera changed: the view looks by the new one. */
  newEye() {
    this.eye = server.camera && cameraEye(server.camera);
    this.screen.ariaLabel = isSurface() ? 'Picture of the surface' : 'Picture of the video';
    if (server.camera && !this.window.chosen && !ui.dragging) this.showAll();
    this.fitToSize();
  }

  /** The pose changed: the floor is drawn around the feet, and the body painted. */
  follow() {
    const hasFloor = Boolean(server.view?.floor);
    if (hasFloor || this.#hadFloor) this.redraw();
    this.#hadFloor = hasFloor;
    this.paint();
  }

  /** Paint the body as it stands now, with what else is drawn in this animation frame. */
  paint() {
    this.el.classList.toggle('painted', this.isPainted);
    if (!this.isPainted || !this.eye || !this.window.width) return;
    const { width, height } = this.window;
    const sharpness = Math.min(devicePixelRatio, GREATEST_SHARPNESS);
    const [across, down] = [width, height].map((px) => Math.round(px * sharpness));
    if (this.#figure.width !== across || this.#figure.height !== down) {
      Object.assign(this.#figure, { width: across, height: down });
    }
    const ctx = this.#figure.getContext('2d');
    ctx.setTransform(across / width, 0, 0, down / height, 0, 0);
    ctx.clearRect(0, 0, width, height);
    if (!paintFigure(ctx, this)) return void delete this.#figure.dataset.frame;
    this.#figure.dataset.frame = String(server.pose.frame);
    this.el.classList.add('drawn');
  }

  #hadFloor = false;

  showAll() {
    if (!server.camera) return;
    const { width, height } = server.camera;
    const room = { x: 0, top: this.topRoom(width, height), bottom: 0 };
    this.window.showBox([-0.5, -0.5, width - 0.5, height - 0.5], room);
    this.window.limit(Math.min(0.1, this.window.scale / 2), GREATEST_SCALE);
  }

  /** A standing film has its head at the top: it begins below the bars. */
  topRoom(width, height) {
    const isStanding = height > width;
    return isStanding && this.isInLargePlace && this.isLarge ? BARS_PX : 0;
  }

  draw() {
    super.draw();
    this.paint();
    if (!server.camera) return;
    place(this.screen, server.camera, this.window);
    showAcross(this.window.scale * devicePixelRatio);
    const { naturalWidth: width, naturalHeight: height } = this.person;
    if (width) place(this.person, server.camera, this.window, { width, height });
  }

  /** Under the body: the picture's edge and the floor. */
  paper() {
    if (!server.camera) return nothing; // the session was just closed: the eye goes a moment later
    const [x, y] = this.window.fromPlane([-0.5, -0.5]);
    const [width, height] = [server.camera.width, server.camera.height].map((n) => n * this.window.scale);
    return svg`<rect class="edge" x=${x} y=${y} width=${width} height=${height} />
      <svg x=${x} y=${y} width=${width} height=${height}
        viewBox=${`${x} ${y} ${width} ${height}`}>${this.#floor()}</svg>`;
  }

  /** The floor around the feet, over the picture and under the body. */
  #floor() {
    if (!server.view?.floor || !ground()) return nothing;
    const { level, floor } = ground();
    const centre = dropped(feetMiddle(), level, floor);
    const paths = gridPaths((p) => this.project(p), { level, floor, centre, reach: FLOOR_REACH_M });
    return svg`<g class="floor">${paths.map(
      ({ d, share, isStrong }) => svg`<path d=${d} stroke-opacity=${(share * (isStrong ? 0.62 : 0.31)).toFixed(3)} />`,
    )}</g>`;
  }

  /** The view's name, on a plate so that it can be read over the film. */
  marks() {
    return this.label('plate');
  }
}
