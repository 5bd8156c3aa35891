// viser's page in an iframe, reduced to a picture: it draws and does nothing else. Applied before
// every picture, since viser may have made a node anew.  Over the film the body is one translucent
// sheet: its opaque solids are drawn first, without colour, so that of everything else only what lies
// in front is seen.  In the small views an observed surface is such a sheet too, after the body that
// stands in it: its nearest layer is drawn without colour, and then that layer alone with its colours.
// Left alone, each page would try once a second and break off the attempt before. But a browser puts
// attempts off by seconds once many have failed, so that none would ever succeed. Hence the page lets
// them try: seldom, and only while it is connected itself. It is of our own origin, so the page
// reaches in through the handle viser leaves on its window.

import { ui, watch } from '../store/state.js';

const FIRST = -1;
const [BEHIND_SHEET, SHEET] = [1, 2];

/** By view and by the kind of node, which is one of the last three words of its name. */
const LOOKS = {
  main: {
    solid: { order: FIRST, colorWrite: false },
    wires: { transparent: true, opacity: 0.38, depthWrite: false },
    ghost: { transparent: true, opacity: 0.75, depthWrite: false },
    trail: { depthTest: false, transparent: true, depthWrite: false },
  },
  small: {
    ghost: { transparent: true, opacity: 0.6, depthWrite: false },
    trail: { depthTest: false, transparent: true, depthWrite: false },
    surface: {
      depth: { order: BEHIND_SHEET, transparent: true, colorWrite: false, depthWrite: true },
      sheet: { order: SHEET, transparent: true, opacity: 0.42, depthWrite: false },
    },
  },
};

/** Apply the looks to the nodes of one view; `nodes` are three.js objects by name. */
export function applyLooks(role, nodes) {
  const looks = LOOKS[role] ?? LOOKS.small;
  for (const name in nodes) {
    const words = name.split('/');
    const look = looks[words.at(-1)] ?? looks[words.at(-2)] ?? looks[words.at(-3)];
    if (look) nodes[name]?.traverse((object) => applyLook(object, look));
  }
}

/** A look may differ by the name of what an object is made of. */
function applyLook(object, look) {
  if (!object.material) return;
  const { order = 0, ...values } = look[object.material.name] ?? look;
  object.renderOrder = order;
  for (const [key, value] of Object.entries(values)) {
    if (object.material[key] !== value) object.material[key] = value;
  }
}

/** Longer than an attempt can take: viser ends it after five seconds. */
const AGAIN_MS = 7000;

/** Reconnect viser's page in this window; returns how to stop. */
export function reconnectSeldom(window) {
  let tried = performance.now(); // a new page tries by itself
  let may = false;
  // viser asks for the focus only when it is not connected.
  window.document.hasFocus = () => {
    if (may) tried = performance.now();
    return may;
  };
  const reconnect = () => {
    if (!ui.connected || performance.now() - tried < AGAIN_MS) return;
    may = true;
    window.dispatchEvent(new Event('focus')); // tries now, and would again each second
    may = false;
    window.dispatchEvent(new Event('blur')); // but does not
  };
  const unwatch = watch(['u:connected'], reconnect);
  const timer = setInterval(reconnect, AGAIN_MS);
  return () => {
    unwatch();
    clearInterval(timer);
  };
}

const BARE = `
  html, body, body * { background: transparent !important; }
  html, body { overflow: hidden !important; cursor: inherit !important; }
  .mantine-Paper-root, .mantine-Modal-root, .mantine-Notifications-root, .mantine-Overlay-root,
  [data-testid^="floating-panel"], .stats-panel { display: none !important; }
`;
const RENDERED_FRAMES = 3;
const GREATEST_DPR = 2;
const POLL_MS = 30;
/** viser wakes once a second even when nothing happens: not after so long. */
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
    const state = inside.scene.__r3f?.root?.getState;
    const { invalidate, gl, setFrameloop } = state?.() ?? {};
    if (!invalidate) return;
    const loop = (kind) => state().frameloop !== kind && setFrameloop(kind);
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
      if (this.#isReady && drawn >= requested && now - requested > AWAKE_MS) return loop('never');
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
      loop('demand');
      invalidate();
      clearTimeout(settled);
      settled = setTimeout(invalidate, this.#pace().settled);
    };
  }
}
