// How well the background agrees with the camera's motion, frame by frame: a thin curve, with a gap where
// nothing is known, coloured where something is doubtful, and a diamond where a person corrected it.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { menuItem } from '../../actions/buttons.js';
import { cameraFindings, cameraKeys, hasFrames, isCameraKey, motion, visitFinding } from '../../actions/camera.js';
import { goTo, settle, stopPlaying } from '../../actions/playhead.js';
import { shortNumber } from '../../controls/arithmetic.js';
import { heading, openMenuAt } from '../../controls/menu.js';
import { server } from '../../store/state.js';
import { clampFrame } from '../../store/clip.js';
import { diamond, plate } from '../draw/glyphs.js';
import { frameAt, GUTTER, hitNear, pxPerFrame, seenOf, x } from '../draw/scale.js';
import { extent, line, memoize, numbers, runsOf } from '../draw/series.js';
import { frames, scrub } from './frames.js';

/** A diamond is hit within this distance. */
const REACH_PX = 9;
/** Of a diamond, px. */
const RADIUS = 5.5;
/** Between the curve and the row's edges, px. */
const MARGIN = 3;
/** The top of the row stands for this error at least, pixels of the film. */
const LEAST_TOP_PX = 0.5;
/** A finding is drawn at least so wide. */
const LEAST_RANGE_PX = 4;

const errors = () => motion()?.error_px ?? [];
const found = () => cameraFindings().filter(hasFrames);

/** What the top of the row stands for, pixels. */
const topOf = memoize((list) => Math.max(LEAST_TOP_PX, extent(numbers(list))?.high ?? 0));

/** The row, and what is said of the frame under the pointer. @type {import('../mark.js').Mark} */
export const cameraLane = {
  kind: 'camera',
  row: 'camera',
  layers: [
    {
      group: 'frames',
      z: 45,
      from: () => [server.camera_motion],
      draw: ({ rows }) => (rows.camera ? drawLane(rows.camera) : nothing),
    },
    {
      group: 'above',
      z: 45,
      from: () => [server.camera_motion],
      draw: ({ rows }) => (rows.camera ? drawLabels(rows.camera) : nothing),
    },
  ],
  hit: ({ x: px }) => (px < GUTTER ? null : { at: clampFrame(frameAt(px)) }),
  grab: (_, place) => scrub(place),
  click: settle,
  menu: frames.menu,
  tip({ at }, rows) {
    const error = errors()[at];
    const words = Number.isFinite(error)
      ? `Frame ${at}: the background agrees within ${shortNumber(error, 2)} px`
      : `Frame ${at}: nothing is known of the camera here`;
    return plate(words, x(at), rows.camera.y + rows.camera.h + 12);
  },
};

/** Frames of which something is doubtful. @type {import('../mark.js').Mark} */
export const cameraFinding = {
  kind: 'camera_finding',
  row: 'camera',
  hit({ x: px }) {
    const index = found().findIndex((one) => px >= ends(one)[0] && px <= ends(one)[1]);
    return index < 0 ? null : { index };
  },
  cursor: 'pointer',
  grab: (_, place) => scrub(place),
  click: ({ index }) => visitFinding(found()[index]),
  menu: frames.menu,
  tip({ index }, rows) {
    const one = found()[index];
    return one ? plate(one.words, (ends(one)[0] + ends(one)[1]) / 2, rows.camera.y + rows.camera.h + 12) : nothing;
  },
};

/** A frame at which a person corrected the camera. @type {import('../mark.js').Mark} */
export const cameraKey = {
  kind: 'camera_key',
  row: 'camera',
  hit: ({ x: px }) => (px < GUTTER - RADIUS || !motion() ? null : hitNear(cameraKeys(), px, REACH_PX)),
  cursor: 'pointer',
  grab: ({ frame: at }, start) => scrub({ ...start, x: x(at) }),
  click({ frame: at }) {
    stopPlaying();
    goTo(at);
  },
  menu({ frame: at }, { page }) {
    if (!isCameraKey(at)) return;
    openMenuAt(
      `Camera at ${at}`,
      [heading(`Camera corrected at ${at}`), menuItem('goTo', at), menuItem('deleteCameraKey', at)],
      page,
    );
  },
  tip: ({ frame: at }, rows) => svg`<path class="hover" d=${diamond(x(at), middle(rows.camera), RADIUS + 3)} />
    ${plate(`Camera corrected at ${at}`, x(at), rows.camera.y + rows.camera.h + 12)}`,
};

const middle = ({ y, h }) => y + h / 2;

/** Where a finding is drawn, wide enough to be hit. */
function ends({ first, last }) {
  const half = Math.max(pxPerFrame() / 2, LEAST_RANGE_PX / 2);
  return [x(first) - half, x(last) + half];
}

function drawLane(row) {
  const most = topOf(errors());
  const y = (value) => row.y + row.h - MARGIN - (value / most) * (row.h - 2 * MARGIN);
  return svg`<g class="camera-lane">${seenOf(found()).map((one) => drawFinding(one, row))}
    <path class="camera-error" d=${runsOf(errors())
      .map((run) => line(run, y))
      .join('')} />
    ${seenOf(cameraKeys()).map(
      (at) => svg`<path class="keymark camera-key" d=${diamond(x(at), middle(row), RADIUS)}
      />`,
    )}</g>`;
}

function drawFinding(one, { y, h }) {
  const [from, to] = ends(one);
  return svg`<rect class=${`camera-finding ${one.kind === 'cut' ? 'cut' : ''}`} x=${from} y=${y + 1} width=${to - from}
    height=${h - 2} rx="2" />`;
}

function drawLabels(row) {
  const y = middle(row) + 4;
  return svg`<text class="lbl" x="12" y=${y}>Camera</text>
    <text class="d" x=${GUTTER - 8} y=${y} text-anchor="end">${shortNumber(topOf(errors()), 1)} px</text>`;
}
