// The Part tab: the selected part's pose and sizes.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { actionButton, actionIcon } from '../actions/buttons.js';
import { position } from './position.js';
import { rotation } from './rotation.js';
import { section } from './section.js';
import { size } from './size.js';
import { selectedPart } from '../store/parts.js';

export function partTab() {
  const part = selectedPart();
  if (!part) return html`${pose()}`;
  return html`${part.parent ? nothing : position()}${rotation(part)}${pose()}${size(part)}`;
}

const POSES = /** @type {const} */ ([
  'fitPose', 'useTracked', 'pasteMirrored', 'swapSides', 'copyPrevious', 'copyNext',
]);

/** Poses taken over whole: fitted, tracked, copied from the keyframes around, mirrored, at rest. */
function pose() {
  return section(
    'Pose',
    html`<div class="lr">
      ${POSES.map((id) => actionButton(id, undefined, { name: undefined }))}
    </div>`,
    html`${actionIcon('copyPose')}${actionIcon('pastePose')}${actionIcon('resetPose')}`,
  );
}
