// The review of the places that are least sure.

import { count } from '../../controls/words.js';
import { answer, goal, isElsewhere, isReviewing, place, places, toggleReview, turn, whyNoPlace, whyNotReview } from '../review.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const REVIEW = {
  review: {
    also: 'worst errors problems check correct verify quality inspect',
    label: 'Review', icon: 'flag', keys: ['Shift R'], on: isReviewing, off: whyNotReview, run: toggleReview,
    title: () => `Look at the places expected to be off by more than ${goal()} px, the worst first`,
  },
  acceptPlace: {
    also: 'confirm ok right review', alone: 'Accept this place',
    label: () => (isElsewhere() ? `Back to ${place().frame}` : 'Accept'),
    title: () => (isElsewhere() ? 'Go to the place that is reviewed' : 'The motion is right here'), keys: ['Enter'], row: 'In review: accept, cannot tell', handledBy: 'review', off: whyNoPlace,
    run: () => answer('accepted'),
  },
  nextPlace: {
    label: 'Next', title: 'Look at the next place, and at this one later', keys: ['N'], row: 'In review: next, previous', handledBy: 'review', off: whyNoPlace, run: () => turn(1),
    also: 'review skip later', alone: 'Next place to review',
  },
  previousPlace: {
    label: 'Previous', keys: ['Shift N'], row: 'In review: next, previous', handledBy: 'review', off: whyNoPlace, run: () => turn(-1),
    also: 'review back', alone: 'Previous place to review',
  },
  cannotTell: {
    also: 'review unclear hidden unknown skip', alone: 'Cannot tell at this place',
    label: 'Cannot tell', title: 'The picture does not show it: leave this place open and do not ask again', keys: ['Shift Enter'],
    row: 'In review: accept, cannot tell', handledBy: 'review', off: whyNoPlace, run: () => answer('unclear'),
  },
  continueReview: {
    also: 'resume review left', alone: 'Continue the review',
    label: 'Continue', icon: 'flag', title: () => `Review: ${count(places().length, 'place')} left`, off: whyNotReview, run: toggleReview,
  },
};
