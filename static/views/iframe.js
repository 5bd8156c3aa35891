// viser's page in an iframe, reduced to a picture: it draws and does nothing else. It is of our own
// origin, so the page reaches in through the handle viser leaves on its window.

import { applyLooks } from './looks.js';
import { reconnectSeldom } from './reconnect.js';

const BARE = `
  html, body, body * { background: transparent !important; }
  html, body { overflow: hidden !important; cursor: inherit !important; }
  .mantine-Paper-root, .mantine-Modal-root, .mantine-Notifications-root, .mantine-Overlay-root,
  [data-testid^="floating-panel"], .stats-panel { display: none !important; }
`;
const RENDERED_FRAMES = 3;
const GREATEST_DPR = 2;
const POLL_MS = 30;
/** viser draws once a second even when nothing happens: not after so long. */
const AWAKE_MS = 5000;
const NODE = '/camera';

/** What viser leaves on its window; nothing while the browser shows a page of its own there. */
function handleOf(frame) {
  try {
    return frame.contentWindow?.__viserMutable;
  } catch {
    return null; // its error page is of another origin
  }
}

/**
 * viser's picture for a role. `aim(camera)` is called before every picture and sets the three.js
 * camera; `ready()` once there is something to see; `pace()` gives how many milliseconds to let
 * pass between two pictures (rest), before the first (behind), and until all is drawn (settled),
 * and whether one picture has to do for all that came at once (once). While `isHidden()` nothing is
 * drawn.
 */
export class Picture {
  #frame = document.createElement('iframe');
  #inside = null;
  #aim;
  #ready;
  #pace;
  #isHidden;
  #role;
  #isReady = false;
  #stopReconnecting = () => {};

  constructor(role, { aim, ready, pace, isHidden }) {
    this.#role = role;
    this.#aim = aim;
    this.#ready = ready;
    this.#pace = pace;
    this.#isHidden = isHidden;
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
    const inside = handleOf(this.#frame);
    if (!inside?.canvas || !inside.cameraControl || !inside.scene || !inside.camera) {
      setTimeout(() => this.#wait(), POLL_MS);
      return;
    }
    if (inside === this.#inside) return;
    this.#inside = inside;
    this.#disableControls(this.#frame.contentWindow, inside);
    this.#takeCamera(inside);
    this.#limitRendering(inside);
    inside.requestRender();
  }

  /** No keys, no mouse, no panels; come back by itself after a lost connection. */
  #disableControls(window, inside) {
    const { cameraControl } = inside;
    for (const button of ['left', 'middle', 'right', 'wheel']) cameraControl.mouseButtons[button] = 0;
    for (const fingers of ['one', 'two', 'three']) cameraControl.touches[fingers] = 0;
    cameraControl.update = () => false;
    const style = window.document.createElement('style');
    style.textContent = BARE;
    window.document.head.append(style);
    this.#stopReconnecting();
    this.#stopReconnecting = reconnectSeldom(window);
  }

  /** The camera is ours: whatever viser did to it, before each picture it is set again. */
  #takeCamera(inside) {
    let rendered = 0;
    this.#isReady = false;
    inside.scene.onBeforeRender = (renderer, _scene, camera) => {
      renderer.toneMapping = 0; // colours as they are named
      applyLooks(this.#role, inside.nodeRefFromName);
      this.#aim(camera);
      if (!inside.nodeRefFromName[NODE] || ++rendered > RENDERED_FRAMES) return;
      if (rendered === RENDERED_FRAMES) {
        this.#isReady = true;
        this.#ready();
      } else inside.requestRender(); // a slow screen may have drawn all it was asked before all had arrived
    };
    inside.camera.updateProjectionMatrix = () => this.#aim(inside.camera);
  }

  /** One picture per request and one after it has settled; viser would draw on for 15 frames. */
  #limitRendering(inside) {
    const { invalidate, gl } = inside.scene.__r3f?.root?.getState?.() ?? {};
    if (!invalidate) return;
    let [planned, settled] = [0, 0];
    let [drawn, unread, skipped] = [0, false, false];
    let requested = performance.now();
    const later = (wait) => {
      planned ||= setTimeout(() => {
        planned = 0;
        invalidate();
      }, wait);
    };
    const render = gl.render.bind(gl);
    gl.render = (...what) => {
      const now = performance.now();
      // A tab in the background may draw a request much later; and until there is something to see,
      // what viser is sent may come later than any request.
      if (this.#isReady && drawn >= requested && now - requested > AWAKE_MS) return;
      if (this.#isReady && this.#isHidden()) return;
      const pace = this.#pace();
      const wait = Math.max(drawn + pace.rest, requested + pace.behind) - now;
      if (wait > 0) return later(wait);
      // With the first picture viser reads what it was sent, and has it all in the second.
      skipped = unread && !skipped && pace.once;
      unread = false;
      if (skipped) return invalidate();
      drawn = now;
      render(...what);
    };
    inside.requestRender = () => {
      const now = performance.now();
      if (!planned) requested = now;
      unread = true;
      invalidate();
      clearTimeout(settled);
      settled = setTimeout(invalidate, this.#pace().settled);
    };
  }
}
