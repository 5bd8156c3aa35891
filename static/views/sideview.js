// The body from above, from the side or from the front, on squared paper.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { clamp } from '../controls/arithmetic.js';
import { server, ui } from '../store/state.js';
import { parallelEye } from './cameras.js';
import { hasBody } from './freescene.js';
import { View } from './view.js';

const STEPS_M = [0.1, 0.5, 1, 5, 10, 50, 100];
const CLOSEST_PX = 14;
const BARS_M = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const LONGEST_BAR_PX = 96;
/** Of the camera's sign from a border. */
const SIGN_PX = 14;
/** So high is the scale at the lower border. */
const SCALE_PX = 16;

/** Lines for what a window shows: fine, coarse, and the two through the camera. */
export function gridLines(window) {
  const fine = STEPS_M.findIndex((step) => step * window.scale >= CLOSEST_PX);
  if (fine < 0) return nothing;
  const [step, coarse] = [STEPS_M[fine], STEPS_M[fine + 1] ?? Infinity];
  const paths = { fine: '', coarse: '', axis: '' };
  const [left, top] = window.toPlane([0, 0]);
  const [right, bottom] = window.toPlane([window.width, window.height]);
  const kindOf = (metres) => {
    if (Math.abs(metres) < step / 2) return 'axis';
    return Math.abs(metres / coarse - Math.round(metres / coarse)) < 1e-6 ? 'coarse' : 'fine';
  };
  for (let k = Math.ceil(left / step); k * step <= right; k++) {
    const x = onWholePixel(window.fromPlane([k * step, 0])[0]);
    paths[kindOf(k * step)] += `M${x} 0V${window.height}`;
  }
  for (let k = Math.ceil(top / step); k * step <= bottom; k++) {
    const y = onWholePixel(window.fromPlane([0, k * step])[1]);
    paths[kindOf(k * step)] += `M0 ${y}H${window.width}`;
  }
  return svg`<path class="fine" d=${paths.fine} /><path class="coarse" d=${paths.coarse} />
    <path class="axis" d=${paths.axis} />`;
}

/** A round length and the pixels it takes. */
export function scaleBar(window) {
  const metres = BARS_M.findLast((length) => length * window.scale <= LONGEST_BAR_PX) ?? BARS_M[0];
  const words = metres < 1 ? `${Math.round(metres * 100)} cm` : `${metres} m`;
  return { pixels: Math.round(metres * window.scale), words };
}

/** One pixel wide lines lie on whole pixels. */
function onWholePixel(x) {
  return Math.floor(x) + 0.5;
}

const SCALES = [4, 20000];
/** How far the body reaches beyond its joints. */
const FLESH_M = 0.1;
const NEAR_M = 1;
const USUAL_BOX = [-1.2, -1.2, 1.2, 1.2];

/** Of other bodies that are so near, where their parts begin: whom one touches is to be seen. */
function nearbyPoints() {
  const own = Object.values(server.pose?.points ?? {});
  return Object.values(server.poses_beside ?? {}).flatMap((Ts) => {
    const points = Object.values(Ts).map((T) => [T[3], T[7], T[11]]);
    const isNear = points.some((p) => own.some((q) => Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < NEAR_M));
    return isNear ? points : [];
  });
}

export class SideView extends View {
  constructor(el) {
    super(el);
    this.window.limit(...SCALES);
  }

  newEye() {
    const points = server.pose ? Object.values(server.pose.points) : [];
    this.eye = parallelEye(this.name, server.views, middleOf(points));
    this.fitToSize();
  }

  /** Keep the body in sight, but never move under a hand. */
  follow() {
    if (!server.pose || ui.dragging) return;
    if (!this.eye) this.newEye();
    const box = this.bodyBox();
    if (this.window.chosen ? this.window.touches(box) : this.window.holds(box)) return;
    this.showAll(this.window.scale); // no nearer than before: a walking body must not pulse
    this.redraw();
  }

  showAll(greatestScale = Infinity) {
    const room = this.isLarge ? { x: 72, top: 64, bottom: 64 } : { x: 8, top: 26, bottom: 20 };
    this.window.showBox(this.bodyBox(nearbyPoints()) ?? USUAL_BOX, room, greatestScale);
  }

  /** The stretch [left, top, right, bottom] of the plane that the body takes, and what is beside it. */
  bodyBox(beside = []) {
    if (!server.pose || !this.eye) return null;
    const points = [...Object.values(server.pose.points), ...beside].map(this.eye.project);
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
    return svg`${gridLines(this.window)}${this.floorLine()}${this.cameraSign()}`;
  }

  /** The floor, which is seen from its edge. */
  floorLine() {
    if (this.name === 'top' || !server.feet || !hasBody()) return nothing;
    const [, y] = this.window.fromPlane([0, -server.feet.floor_m]);
    return svg`<path class="floor" d=${`M0 ${y.toFixed(1)}H${this.window.width}`} />`;
  }

  /** Where the camera stands, at the border it lies beyond. One that moves stands where it is, and points
   * where it looks. */
  cameraSign() {
    const { width, height } = this.window;
    if (this.name === 'front') return nothing;
    const usual =
      this.name === 'top'
        ? [this.isInLargePlace ? width / 2 : width - SIGN_PX - 2, height - SIGN_PX]
        : [SIGN_PX, height / 2];
    const { at, turn } =
      server.camera_motion?.counts && this.eye ? this.cameraHere() : { at: usual, turn: this.name === 'top' ? -90 : 0 };
    return svg`<g class="camera" transform="translate(${at.join(' ')}) rotate(${turn})">
      <rect x="-5.5" y="-4" width="8" height="8" rx="1.5" />
      <path d="M2.5-1.5 6.5-4v8L2.500 1.500" /></g>`;
  }

  /** The camera of the present frame, kept within the view. */
  cameraHere() {
    const { width, height } = this.window;
    const [x, y] = this.project([0, 0, 0]);
    const [ahead, down] = this.project([0, 0, 1]);
    const at = [clamp(x, SIGN_PX, width - SIGN_PX), clamp(y, SIGN_PX, height - SIGN_PX - SCALE_PX)].map((px) =>
      px.toFixed(1),
    );
    return { at, turn: ((Math.atan2(down - y, ahead - x) * 180) / Math.PI).toFixed(1) };
  }

  marks() {
    const bar = scaleBar(this.window);
    return html`${this.label()}
      <div class="scale"><i style="width:${bar.pixels}px"></i>${bar.words}</div>`;
  }
}

function middleOf(points) {
  const sum = points.reduce((a, p) => [a[0] + p[0], a[1] + p[1], a[2] + p[2]], [0, 0, 0]);
  return sum.map((total) => total / (points.length || 1));
}
