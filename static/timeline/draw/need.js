// What one keyframe more would mend at each frame, as a low hill along the foot of the keyframes' row:
// the suggested key stands at its top. Without a suggested key there is nothing to explain.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { visible, x } from './scale.js';
import { extent, numbers } from './series.js';

const HIGH = 8;

export function drawNeed(rows) {
  const need = numbers(server.need);
  const most = server.suggest?.kind === 'key' ? extent(need)?.high : null;
  if (!(most > 0)) return nothing;
  const foot = rows.keys.y + rows.keys.h - 1;
  // A lost stretch needs it a hundred times more than others, which still have their hill.
  const top = (value) => foot - HIGH * Math.sqrt(value / most);
  return svg`<path class="need" d=${hills(need, foot, top)}>
    <title>How much one keyframe more would mend here</title></path>`;
}

function hills(need, foot, top) {
  const { first, last } = visible();
  const from = Math.max(0, Math.floor(first) - 1);
  const to = Math.min(need.length - 1, Math.ceil(last) + 1);
  let path = '';
  let open = false;
  for (let at = from; at <= to; at += 1) {
    const known = !Number.isNaN(need[at]);
    if (known) path += `${open ? 'L' : `M${x(at).toFixed(1)} ${foot}L`}${x(at).toFixed(1)} ${top(need[at]).toFixed(1)}`;
    else if (open) path += `V${foot}Z`;
    open = known;
  }
  return open ? `${path}V${foot}Z` : path;
}
