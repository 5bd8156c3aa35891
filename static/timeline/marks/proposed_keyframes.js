// What could be keyframes: the one suggested next, how much one is needed where, and those of a reduction.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { draftFrames, isKey, keyFrames, suggestedFrame } from '../../actions/playhead.js';
import { isReviewing } from '../../actions/review.js';
import { server, ui } from '../../store/state.js';
import { seenOf, x } from '../draw/scale.js';
import { extent, numbers, runsOf } from '../draw/series.js';
import { diamond } from '../draw/glyphs.js';

/** @type {import('../mark.js').Mark} */
export const proposedKeyframes = {
  kind: 'proposed',
  layers: [
    { group: 'frames', z: 70, from: () => [server.need, server.suggest], draw: ({ rows }) => drawNeed(rows.keys) },
    { group: 'frames', z: 110, from: () => [suggestedFrame(), server.keys, Boolean(ui.review)], draw: drawSuggestion },
    {
      group: 'frames',
      z: 140,
      from: () => [server.reduction, server.keys],
      draw: ({ rows }) => drawReduced(rows.keys.middle),
    },
  ],
};

/** A dashed diamond with a plus, and a dashed line through all rows. */
function drawSuggestion({ rows, bottom }) {
  const at = isReviewing() ? null : suggestedFrame();
  if (at === null || isKey(at) || draftFrames().includes(at)) return nothing;
  const [there, { middle }] = [x(at), rows.keys];
  // Before the first key the line would say no more than the playhead does.
  const through = keyFrames().length > 0 ? `M${there} ${rows.top}V${bottom}` : '';
  return svg`<path class="s-acc through" d=${through} /><path class="suggested" d=${diamond(there, middle, 9)} />
    <path class="s-acc plus" d=${`M${there - 3.5} ${middle}h7M${there} ${middle - 3.5}v7`} />`;
}

const RADIUS = 6;
const LEAST_RADIUS = 2.5;

function drawReduced(middle) {
  if (!server.reduction) return nothing;
  const frames = seenOf(server.reduction.frames).filter((at) => !isKey(at));
  const marks = frames.map((at, i) => diamond(x(at), middle, radiusAt(frames, i)));
  return svg`<path class="reduced" d=${marks.join('')}><title>Keyframes of the reduction</title></path>`;
}

/** As large as its neighbours leave room for. */
function radiusAt(frames, i) {
  const room = Math.min(
    ...[frames[i - 1], frames[i + 1]].filter((one) => one !== undefined).map((one) => Math.abs(x(one) - x(frames[i]))),
  );
  return Math.min(RADIUS, Math.max(LEAST_RADIUS, room * 0.45));
}

const HIGH = 8;

/** The suggested key stands at the top of the hill; without one there is nothing to explain. */
function drawNeed({ y, h }) {
  const need = numbers(server.need);
  const most = server.suggest?.kind === 'key' ? extent(need)?.high : null;
  if (!(most > 0)) return nothing;
  const foot = y + h - 1;
  // A lost stretch needs it a hundred times more than others, which still have their hill.
  const point = ({ x: at, high }) => `L${at.toFixed(1)} ${(foot - HIGH * Math.sqrt(high / most)).toFixed(1)}`;
  const hills = runsOf(need).map((run) => `M${run[0].x.toFixed(1)} ${foot}${run.map(point).join('')}V${foot}Z`);
  return svg`<path class="need" d=${hills.join('')}>
    <title>Expected improvement from a keyframe here</title></path>`;
}
