// The keyframes that a reduction would leave: diamonds that are not there yet, ticks where they stand
// close.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { isKey } from '../../actions/playhead.js';
import { diamond } from './keymarks.js';
import { visible, x } from './scale.js';

const RADIUS = 6;
const LEAST_RADIUS = 2.5;

export function drawReduced(rows) {
  if (!server.reduction) return nothing;
  const { first, last } = visible();
  const frames = server.reduction.frames.filter((at) => first - 1 <= at && at <= last + 1 && !isKey(at));
  const marks = frames.map((at, i) => diamond(x(at), rows.keys.middle, radiusAt(frames, i)));
  return svg`<path class="reduced" d=${marks.join('')}><title>Keyframes of the reduction</title></path>`;
}

/** As large as its neighbours leave room for. */
function radiusAt(frames, i) {
  const room = Math.min(...[frames[i - 1], frames[i + 1]].filter((one) => one !== undefined).map((one) => Math.abs(x(one) - x(frames[i]))));
  return Math.min(RADIUS, Math.max(LEAST_RADIUS, room * 0.45));
}
