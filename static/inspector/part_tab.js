// The Part tab: the selected part's pose and sizes.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { actionButton, actionIcon } from '../actions/buttons.js';
import { limbs } from './limbs.js';
import { floor, pins, pinsComeFirst } from './pins.js';
import { position } from './position.js';
import { rotation } from './rotation.js';
import { section } from './section.js';
import { size } from './size.js';
import { selectedPart } from '../store/parts.js';
import { isSurface } from '../store/subject.js';

export function partTab() {
  const part = selectedPart();
  if (!part) return html`${limbs()}${pose()}`;
  const pinned = isSurface() ? nothing : html`${pins(part)}${floor(part)}`;
  const isFirst = pinsComeFirst(part);
  return html`${limbs()}${isFirst ? pinned : nothing}${part.parent ? nothing : position()}${rotation(part)}${pose()}${size(part)}${isFirst ? nothing : pinned}`;
}

const POSES = /** @type {const} */ ([
  'fitPose', 'keyLimb', 'useTracked', 'pasteMirrored', 'swapSides', 'turnInDepth', 'copyPrevious', 'copyNext',
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
