// What a drag will do, as far as the page can tell by itself while the server does not answer: the
// handle goes with the pointer, and with it the lines to its neighbours. The body stays where it was
// last seen, for how it follows only the server knows.

import { svg, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, watch } from '../store/state.js';
import { interaction, redrawSoon } from './interaction.js';
import { pathOf } from './space.js';

const RADIUS = 9;

/** Where handles were let go of since the line was lost, by the handle: the newest place of each. */
let left = new Map();

/** Forget the preview once the server shows what it was about. */
export function mountOffline() {
  watch(['u:connected'], () => {
    if (!ui.connected || !left.size) return;
    left = new Map();
    redrawSoon();
  });
}

/** A drag has ended whose moves still wait. */
export function keepPreview(drag) {
  const spot = spotOf(drag);
  if (ui.connected || !spot) return;
  left.set(spot.key, spot);
}

/** The handles that wait for the server, in the view they were dragged in. */
export function drawOffline(view) {
  if (ui.connected) return nothing;
  const now = interaction.drag && spotOf(interaction.drag);
  const spots = [...left.values()].filter(({ key }) => key !== now?.key);
  const shown = [...spots, ...(now ? [now] : [])].filter((spot) => spot.view === view.name && spot.frame === server.view.frame);
  return svg`<g class="offline">${shown.map((spot) => drawSpot(view, spot))}</g>`;
}

/** Where a drag has its handle: {key, view, at, frame, neighbours}; null for one without a place of its own. */
function spotOf(drag) {
  const key = drag.target?.key ?? '';
  const given = server.body?.handles.find(({ name }) => key === `grip:${name}`);
  if (!given) return null;
  const neighbours = neighboursOf(given.anchor, server.body.parts, server.pose.points);
  return { key, view: drag.view, at: drag.toView(drag.virtual), frame: server.view.frame, neighbours };
}

/**
 * The points that a joint or landmark is joined to by parts of the body.
 * @param {string} anchor  Its name: a part's, for its joint, or a landmark's.
 * @param {{ name: string, parent: string | null, landmarks: string[] }[]} parts
 * @param {Record<string, number[]>} points
 */
export function neighboursOf(anchor, parts, points) {
  const part = parts.find(({ name }) => name === anchor);
  const owner = parts.find(({ landmarks }) => landmarks.includes(anchor));
  const names = part
    ? [part.parent, ...parts.filter(({ parent }) => parent === anchor).map(({ name }) => name)]
    : [owner?.name];
  return names.filter((name) => name && points[name]).map((name) => points[name]);
}

function drawSpot(view, { at, neighbours }) {
  const [x, y] = view.fromView(at);
  const lines = neighbours.map((point) => pathOf([view.project(point), [x, y]])).join('');
  return svg`<path class="casing" d=${lines} /><path class="line" d=${lines} />
    <circle class="casing" cx=${x} cy=${y} r=${RADIUS} /><circle class="spot" cx=${x} cy=${y} r=${RADIUS} />
    <text x=${x + RADIUS + 7} y=${y + 4}>Preview</text>`;
}
