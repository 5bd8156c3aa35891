// viser's page in an iframe, tamed to a picture: it draws and does nothing else. It is of our own
// origin, so the page reaches in through the handle viser leaves on its window.

import { dress } from './looks.js';
import { keepLine } from './reviving.js';

const TAMED = `
  html, body, body * { background: transparent !important; }
  html, body { overflow: hidden !important; cursor: inherit !important; }
  .mantine-Paper-root, .mantine-Modal-root, .mantine-Notifications-root, .mantine-Overlay-root,
  [data-testid^="floating-panel"], .stats-panel { display: none !important; }
`;
const RENDERED_FRAMES = 3;
const GREATEST_DPR = 2;
const POLL_MS = 30;
const SETTLED_MS = 120;
/** viser draws once a second even when nothing happens: not after so long. */
const AWAKE_MS = 5000;
const NODE = '/camera';

/**
 * viser's picture for a role. `aim(camera)` is called before every picture and sets the three.js
 * camera; `ready()` once there is something to see; `rest()` tells how many milliseconds to let
 * pass between two pictures.
 */
export class Picture {
  #frame = document.createElement('iframe');
  #inside = null;
  #aim;
  #ready;
  #rest;
  #role;
  #leaveLine = () => {};

  constructor(role, { aim, ready, rest }) {
    this.#role = role;
    this.#aim = aim;
    this.#ready = ready;
    this.#rest = rest;
    this.#frame.className = 'viser';
    this.#frame.title = '';
    this.#frame.tabIndex = -1;
    this.#frame.inert = true;
    this.#frame.ariaHidden = 'true';
    this.#frame.addEventListener('load', () => this.#wait());
  }

  get element() {
    return this.#frame;
  }

  /** Draw anew: the window or the camera changed. */
  redraw() {
    this.#inside?.requestRender();
  }

  /** As large as its place, in whole pixels, with the picture of this very moment in it. */
  resize(width, height) {
    this.#frame.style.width = `${width}px`;
    this.#frame.style.height = `${height}px`;
    this.redraw(); // else a canvas at rest would stay as empty as its new size makes it
    this.#inside?.syncCanvasSize?.(width, height);
  }

  /** Fetch viser's page. It learns the sharpness of the screen then: another one, another page. */
  load() {
    const sharpness = Math.min(devicePixelRatio, GREATEST_DPR);
    const settings = `fixedDpr=${sharpness}&darkMode=1&hideViserLogo=1`;
    this.#frame.src = `/view/${this.#role}?${settings}`;
    const screen = matchMedia(`(resolution: ${devicePixelRatio}dppx)`);
    screen.addEventListener('change', () => this.load(), { once: true });
  }

  #wait() {
    const inside = this.#frame.contentWindow?.__viserMutable;
    if (!inside?.canvas || !inside.cameraControl || !inside.scene || !inside.camera) {
      setTimeout(() => this.#wait(), POLL_MS);
      return;
    }
    if (inside === this.#inside) return;
    this.#inside = inside;
    this.#quieten(this.#frame.contentWindow, inside);
    this.#takeCamera(inside);
    this.#calm(inside);
    inside.requestRender();
  }

  /** No keys, no mouse, no panels; come back by itself after a lost connection. */
  #quieten(window, inside) {
    const { cameraControl } = inside;
    for (const button of ['left', 'middle', 'right', 'wheel']) cameraControl.mouseButtons[button] = 0;
    for (const fingers of ['one', 'two', 'three']) cameraControl.touches[fingers] = 0;
    cameraControl.update = () => false;
    const style = window.document.createElement('style');
    style.textContent = TAMED;
    window.document.head.append(style);
    this.#leaveLine();
    this.#leaveLine = keepLine(window);
  }

  /** The camera is ours: whatever viser did to it, before each picture it is set again. */
  #takeCamera(inside) {
    let rendered = 0;
    inside.scene.onBeforeRender = (renderer, _scene, camera) => {
      renderer.toneMapping = 0; // colours as they are named
      dress(this.#role, inside.nodeRefFromName);
      this.#aim(camera);
      if (inside.nodeRefFromName[NODE] && ++rendered === RENDERED_FRAMES) this.#ready();
    };
    inside.camera.updateProjectionMatrix = () => this.#aim(inside.camera);
  }

  /** One picture per wish and one after it has settled; viser would draw on for 15 frames. */
  #calm(inside) {
    const { invalidate, gl } = inside.scene.__r3f?.root?.getState?.() ?? {};
    if (!invalidate) return;
    let settled = 0;
    let drawn = 0;
    let wished = performance.now();
    const render = gl.render.bind(gl);
    gl.render = (...what) => performance.now() - wished < AWAKE_MS && render(...what);
    const draw = () => {
      drawn = performance.now();
      invalidate();
    };
    inside.requestRender = () => {
      wished = performance.now();
      const wait = drawn + this.#rest() - performance.now();
      if (wait <= 0) draw();
      clearTimeout(settled);
      settled = setTimeout(draw, Math.max(wait, SETTLED_MS));
    };
  }
}
