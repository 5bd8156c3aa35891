// Words beside the pointer's work: the value while something is dragged, the name of what is
// under a resting pointer.

import { degrees } from '../actions/angles.js';
import { clamp } from '../controls/arithmetic.js';
import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { view as viewNamed } from '../views/views.js';
import { boxCornersIn } from './boxcorners.js';
import { interaction } from './interaction.js';
import { drawKeypointName } from './keypoints.js';
import { drawPlaceName } from './marks.js';
import { isLarge, largeView, ringRadius } from './scale.js';
import { drawSketchLabel } from './sketch.js';
import { isReady, targetsIn } from './targets.js';

const AWAY = 20;
/** What the longest words take. */
const ROOM = 216;
const hosts = new Map();

/** The charted angle at its joints, at the present frame. */
function drawAngles(view) {
  const shown = server.joint_angle;
  if (!shown || view.name !== 'main' || ui.dragging || !isReady(view)) return nothing;
  return shown.sides.map(({ side, part, values }) => {
    const [point, value] = [server.pose?.points[part], values[server.view.frame] ?? null];
    if (!point || value === null) return nothing;
    const [left, top] = view.project(point);
    return Number.isFinite(left + top)
      ? html`<div class="flt num jointangle ${side}"
        style="left:${left + AWAY}px;top:${top - AWAY}px">${degrees(value)}</div>`
      : nothing;
  });
}

/** Draw a view's labels. */
export function drawLabels(view) {
  const { keypoints } = targetsIn(view);
  render(
    [
      drawAngles(view),
      drawValue(view),
      drawName(view),
      drawSketchLabel(view),
      drawKeypointName(view, keypoints),
      ui.dragging ? nothing : drawPlaceName(view),
    ],
    hostOf(view),
  );
}

function hostOf(view) {
  if (!hosts.has(view.name)) {
    const host = document.createElement('div');
    host.className = 'hud';
    view.el.append(host);
    hosts.set(view.name, host);
  }
  return hosts.get(view.name);
}

/** What the gesture does, beside what it moves; where it happens and in the large view. */
function drawValue(view) {
  const gesture = server.pose?.gesture;
  const where = interaction.drag?.view ?? largeView();
  if (!gesture || !isReady(view) || view.name !== where || !isLarge(view)) return nothing;
  const place = gesture.axis ? besideRing(view, gesture) : besideGrip(view, gesture);
  if (!place) return nothing;
  return html`<div class="flt num ${place.left ? 'left' : ''}" style="left:${place.x}px;top:${place.y}px">
    ${words(gesture)}
  </div>`;
}

function words(gesture) {
  const change = gesture.axis
    ? html`${gesture.value} <span class=${gesture.axis}>${gesture.change}</span>`
    : html`<span class="mut">${gesture.value} ${gesture.change}</span>`;
  return html`${gesture.label} ${change}${unreachedWords(gesture)}`;
}

/** What was to stay in its place and cannot, and what may be done about it. */
function unreachedWords({ unreached }) {
  if (!unreached.length) return nothing;
  const labels = unreached.map((name) => server.body.handles.find((handle) => handle.name === name)?.label ?? name);
  const more = labels.length > 1 ? ` and ${labels.length - 1} more` : '';
  return html`<div class="unreached">${labels[0]}${more} cannot reach<br />Alt takes them along</div>`;
}

function besideRing(view, gesture) {
  const centre = server.pose.points[gesture.part];
  if (!centre) return null;
  const [x, y] = view.project(centre);
  return beside(view, x, y, ringRadius(view) + AWAY, false);
}

function besideGrip(view, gesture) {
  const target = interaction.drag?.target;
  const anchor = server.body.handles.find(({ name }) => target?.key === `grip:${name}`)?.anchor;
  const point = cornerPoint(target) ?? server.pose.points[anchor ?? gesture.part];
  if (!point) return null;
  const [x, y] = view.project(point);
  const middle = gesture.reach ? view.project(gesture.reach.centre)[0] : x - 1;
  // Away from the limb, which the eye needs.
  return beside(view, x, y + (gesture.reach ? 26 : 0), AWAY, x < middle);
}

/** Where the dragged corner of a box is now. */
const cornerPoint = (target) =>
  target?.kind === 'box_corner' ? boxCornersIn(viewNamed('main')).find(({ key }) => key === target.key)?.point : null;

/** Right or left of a place as wished; at the border of the view below it. */
function beside(view, x, y, away, left) {
  const { width, height } = view.window;
  const fits = left ? x - away > ROOM : x + away + ROOM < width;
  const across = fits ? (left ? x - away : x + away) : left ? ROOM : width - ROOM;
  const down = fits ? y - 12 : y + away + 8;
  return { x: across, y: clamp(down, 8, height - 32), left };
}

function drawName(view) {
  const over = interaction.over;
  if (!over?.named || over.view !== view.name || ui.dragging) return nothing;
  const { x, y } = over.at;
  const left = x + 150 > view.el.clientWidth;
  return html`<div class="flt row name ${left ? 'left' : ''}" style="left:${x + (left ? -10 : 14)}px;top:${y + 16}px">
    ${
      over.side
        ? html`<span class="dot"
      style="background:var(--b${over.side})"></span>`
        : nothing
    }${over.label}${over.which ? html` <span class="mut">${over.which}</span> <kbd>Tab</kbd>` : nothing}
  </div>`;
}
