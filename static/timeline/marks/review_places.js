// Places to review: triangles below the ruler.

import { svg } from '../../vendor/lit-html/lit-html.js';
import { settle } from '../../actions/playhead.js';
import { isReviewing, place as current, places, visitOrOpen } from '../../actions/review.js';
import { unanswered } from '../../actions/review_list.js';
import { server, ui } from '../../store/state.js';
import { nearest, RULER, seenOf, x } from '../draw/scale.js';
import { scrub } from './frames.js';

const HALF = 4;
const REACH_PX = 7;

/** @type {import('../mark.js').Mark} */
export const reviewPlace = {
  kind: 'review',
  layers: [
    {
      group: 'frames',
      z: 160,
      from: () => [server.review, ui.review, ui.reviewGoal, ui.reviewLeft],
      draw: () => seenOf(open()).map(draw),
    },
  ],
  hit({ x: px, y }) {
    if (y < RULER - 2 || y > RULER + 2 * HALF + 2) return null;
    const at = nearest(
      open().map(({ frame }) => frame),
      px,
      REACH_PX,
    );
    return open().find(({ frame }) => frame === at);
  },
  grab: ({ frame }, start) => scrub({ ...start, x: x(frame) }),
  click({ id }) {
    settle();
    visitOrOpen(id);
  },
};

/** Those that wait for an answer, while they are reviewed or the review was left. */
function open() {
  if (!isReviewing()) return ui.reviewLeft ? places() : [];
  return unanswered(ui.review, places());
}

const draw = ({ id, frame }) => svg`<path class="review-place ${id === current()?.id ? 'on' : ''}"
  d=${`M${x(frame) - HALF} ${RULER + 1}h${2 * HALF}l${-HALF} ${HALF + 2}z`} />`;
