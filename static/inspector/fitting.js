// Fits to the pictures: of the pose at the present frame, and of the body's sizes to all keyframes.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { button, checkbox } from '../controls/fields.js';
import { isSurface, words } from '../store/subject.js';

/** Improve the pose of the present frame from its picture; the server says why it cannot. */
export function fitHere() {
  send({ do: 'fit_here' });
}

export function fitHereButton() {
  return button({
    name: 'wand', label: 'Fit here', key: 'F', act: fitHere, off: unposed(),
    title: `Lay this pose onto what the ${words().what} shows; one step to undo`,
  });
}

/** Sizes are found in pictures alone. */
export function fitSizesRow() {
  if (isSurface()) return nothing;
  const count = server.keys?.frames.length ?? 0;
  return html`<div class="fitsizes">
    ${button({
      name: 'wand', label: 'Fit sizes',
      off: count < 2 ? 'Pose a second keyframe first' : '',
      title: `Find the sizes that fit the pictures of all ${count} keyframes; one step to undo`,
      act: () => send({ do: 'fit_sizes', focal: Boolean(ui.fitFocal) }),
    })}
    ${checkbox({
      label: 'With focal length', on: Boolean(ui.fitFocal), act: (on) => setUi('fitFocal', on),
      title: 'Find the lens as well, where it is only a guess',
    })}
  </div>`;
}

/** Why no pose can be fitted yet, or ''. Into a surface the body is laid as it first stands, too. */
function unposed() {
  if (isSurface()) return '';
  const { frames = [], drafts = [] } = server.keys ?? {};
  return frames.length + drafts.length ? '' : 'Pose the body roughly first';
}
