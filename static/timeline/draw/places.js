// Places to review, as triangles over the keyframes' row: amber, the current one in the accent.

import { svg } from '../../vendor/lit-html/lit-html.js';
import { isReviewing, place, places } from '../../actions/review.js';
import { answerOf } from '../../actions/review_list.js';
import { ui } from '../../store/state.js';
import { RULER, visible, x } from './scale.js';

const HALF = 4;
const REACH = 7;

/** Those that wait for an answer, while they are reviewed or the review was left. */
function open() {
  if (!isReviewing()) return ui.reviewLeft ? places() : [];
  return places().filter(({ id }) => !answerOf(ui.review, id));
}

export function drawReviewPlaces() {
  const { first, last } = visible();
  const seen = open().filter(({ frame }) => frame >= first && frame <= last);
  return seen.map(({ id, frame }) => {
    const at = x(frame);
    return svg`<path class="review-place ${id === place()?.id ? 'on' : ''}"
      d=${`M${at - HALF} ${RULER + 1}h${2 * HALF}l${-HALF} ${HALF + 2}z`} />`;
  });
}

/** The place whose triangle is at a pixel, or null. */
export function reviewPlaceNear(px, py) {
  if (py < RULER - 2 || py > RULER + 2 * HALF + 2) return null;
  const near = open().filter(({ frame }) => Math.abs(x(frame) - px) <= REACH);
  return near.sort((a, b) => Math.abs(x(a.frame) - px) - Math.abs(x(b.frame) - px))[0] ?? null;
}
