// Keypoints on the picture: a ring each, whose arc is how sure the detector is. Dragging one says where
// the joint is seen; the pose stays.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { openMenuAt } from '../controls/menu.js';
import { server, ui } from '../store/state.js';
import {
  arcOf,
  correction,
  keypointActions,
  keypointsHere,
  percentOf,
  ringsAreShown,
  unsure,
  worstOf,
} from '../actions/keypoints.js';
import { beginDrag } from './drag.js';
import { isDragged, isHot } from './interaction.js';
import { distance } from './space.js';
import { isDrawingTool } from './sketch.js';

const RADIUS = 5.5;
const UNSURE_RADIUS = 8;
/** From its middle; a handle of the body near it is reached outside. */
const REACH = 10;
const LABEL_ROOM = 150;

/** The rings in a view; none but over the picture. */
export function keypointsIn(view) {
  if (view.name !== 'main' || !ringsAreShown() || isDrawingTool(ui.tool)) return [];
  return keypointsHere().map((point) => {
    const { frame } = server.keypoints;
    return {
      key: `keypoint:${point.joint}`,
      kind: 'keypoint',
      point,
      label: '',
      reach: REACH,
      at: view.fromView(point.at),
      frame,
      begin,
      click: stays,
      clickTwice: stays,
      menu: (place) => openKeypointMenu(point, frame, place),
    };
  });
}

const stays = () => {};

function begin(view, press, target, from) {
  const { point, frame } = target;
  const messageAt = (at) =>
    correction(
      point,
      frame,
      [0, 1].map((k) => point.at[k] + at[k] - from[k]),
    );
  beginDrag(view, press, messageAt, { target, hint: 'keypoint', gentle: true });
}

/** The ring that a pointer at (x, y) means, or null. */
export function ringAt(rings, x, y, finger) {
  const near = rings
    .map((ring) => ({ ring, away: distance(ring.at, [x, y]) }))
    .filter(({ ring, away }) => away <= ring.reach * finger);
  near.sort((a, b) => a.away - b.away);
  return near[0]?.ring ?? null;
}

export function drawKeypoints(view, rings) {
  return svg`<g class="keypoints">${rings.map((ring) => drawRing(view, ring))}</g>`;
}

function drawRing(view, ring) {
  const { point } = ring;
  const [x, y] = ring.at;
  const r = unsure(point) ? UNSURE_RADIUS : RADIUS;
  const hot = isHot(view, ring) || isDragged(ring) || ui.keypointHover === point.joint;
  const classes = `keypoint ${point.state} ${unsure(point) ? 'unsure' : ''} ${hot ? 'hot' : ''}`;
  return svg`<g class=${classes} data-keypoint=${point.joint}>
    <circle class="edge" cx=${x} cy=${y} r=${r} />
    <circle class="rest" cx=${x} cy=${y} r=${r} />
    ${
      point.state === 'ignored'
        ? svg`<path class="out" d="M${x - r} ${y + r}L${x + r} ${y - r}" />`
        : svg`<path class="arc" d=${arcOf(x, y, r, point.sure)} />`
    }
    ${point.state === 'corrected' ? svg`<circle class="set" cx=${x} cy=${y} r="2" />` : nothing}
  </g>`;
}

/** "Right wrist 58 %" beside the ring under the pointer; beside the worst one where it is unsure. */
export function drawKeypointName(view, rings) {
  const named =
    rings.find((ring) => isHot(view, ring) || isDragged(ring)) ??
    rings.find(({ point }) => point.joint === (ui.keypointHover ?? worstOf(keypointsHere())?.joint));
  if (!named) return nothing;
  const [x, y] = named.at;
  const left = x + LABEL_ROOM > view.el.clientWidth;
  const tone = unsure(named.point) ? 'warned' : 'mut';
  return html`<div class="flt kp num ${left ? 'left' : ''}" style="left:${x + (left ? -16 : 16)}px;top:${y - 12}px">
    ${named.point.label} <span class=${tone}>${percentOf(named.point)}</span>
  </div>`;
}

/** What can be done with a keypoint, at a place of the window. */
export function openKeypointMenu(point, frame, place) {
  openMenuAt(point.label, keypointActions(point, frame), place);
}
