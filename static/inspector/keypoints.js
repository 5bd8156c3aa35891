// How sure the detector is of each joint in the frame that is shown.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../store/state.js';
import { fewOf, FEW, keypointsHere, percentOf, unsure } from '../actions/keypoints.js';
import { isOn, keyOf, labelOf, perform, titleOf } from '../actions/actions.js';
import { openKeypointMenu } from '../handles/keypoints.js';
import { section } from './section.js';

/** Nothing where no keypoints are known of this frame. */
export function keypoints() {
  const points = keypointsHere();
  if (points.length === 0) return nothing;
  const rows = ui.allKeypoints ? points : fewOf(points);
  return section(
    'Keypoints here',
    html`<div class="kps" role="group" aria-label="Keypoints here">${rows.map(row)}</div>
    <div class="kps-foot">
      <button type="button" class="btn sm ${isOn('rings') ? 'on' : ''}" aria-pressed=${isOn('rings')}
        title=${titleOf('rings')} data-key=${keyOf('rings') || nothing} @click=${() => perform('rings')}>${labelOf('rings')}</button>
      ${points.length > FEW ? html`<button type="button" class="btn sm ghost" aria-expanded=${Boolean(ui.allKeypoints)}
        @click=${() => setUi('allKeypoints', !ui.allKeypoints)}>${ui.allKeypoints ? 'Fewer' : `All ${points.length}`}</button>` : nothing}
    </div>`,
  );
}

function row(point) {
  const { frame } = server.keypoints;
  const open = (event) => {
    event.preventDefault();
    const { left, bottom } = event.currentTarget.getBoundingClientRect();
    openKeypointMenu(point, frame, [left, bottom]);
  };
  const mark = (joint) => () => setUi('keypointHover', joint);
  return html`<button type="button" class="kp ${unsure(point) ? 'unsure' : ''}" aria-haspopup="menu"
    title=${`${point.label}: put back or ignore here. Drag its ring to correct it`}
    @click=${open} @contextmenu=${open} @mouseenter=${mark(point.joint)} @mouseleave=${mark(null)}
    @focus=${mark(point.joint)} @blur=${mark(null)}>
    <span class="cut">${point.label}</span>
    <span class="bar"><i style="width:${Math.round(100 * point.sure)}%"></i></span>
    <span class="num">${percentOf(point)}</span>
  </button>`;
}
