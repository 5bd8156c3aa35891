// Tracking, drafting, reducing, reviewing; what is wrong; commands and keys.

import { toggleSearch, toggleSheet } from '../../controls/dialogs.js';
import { count } from '../../controls/words.js';
import { server, setUi } from '../../store/state.js';
import { words } from '../../store/clip.js';
import { draftLabel, draftMessage, draftTimeWords, restCount, whyNotDraft, whyNotDraftRest, whyNotDrawBox } from '../drafting.js';
import { nextProblem, problems } from '../playhead.js';
import { beginReduction, whyNotReduce } from '../proposals.js';
import {
  answer, goal, isElsewhere, isReviewing, place, places, toggleReview, turn, whyNoPlace, whyNotAnswer, whyNotReview,
} from '../review.js';
import { liftWords, whyNotFindUp, whyNotLift, whyNotStand } from '../standing.js';
import {
  changedSegments, chosenSegments, chosenTail, namesOf, trackMessage, trackSegment, whyNotAhead,
  whyNotTrackChanged, whyNotTrackChosen, whyNotTrackThis,
} from '../tracking.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const REVIEW = {
  review: {
    also: 'worst errors problems check correct verify quality inspect',
    label: 'Review', icon: 'flag', keys: ['Shift R'], on: isReviewing, off: whyNotReview, run: toggleReview,
    title: () => `Look at the places${chosenTail().replace(',', ' within')} expected to be off by more than ${goal()} px, the worst first`,
  },
  acceptPlace: {
    also: 'confirm ok right review', alone: 'Accept this place',
    label: () => (isElsewhere() ? `Back to ${place().frame}` : 'Accept'),
    title: () => (isElsewhere() ? 'Go to the place that is reviewed' : 'The motion is right here'), keys: ['Enter'], row: 'In review: accept, cannot tell', handledBy: 'review', off: whyNotAnswer,
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
    row: 'In review: accept, cannot tell', handledBy: 'review', off: whyNotAnswer, run: () => answer('unclear'),
  },
  continueReview: {
    also: 'resume review left', alone: 'Continue the review',
    label: 'Continue', icon: 'flag', title: () => `Review: ${count(places().length, 'place')} left`, off: whyNotReview, run: toggleReview,
  },
};

/** @satisfies {Record<string, Action>} */
export const TRACK = {
  trackChanged: {
    also: 'solve run compute process calculate outdated update',
    label: () => `${words().verb} changed segments${chosenTail()}`, icon: 'track', keys: ['T'], off: whyNotTrackChanged,
    title: () => `${words().verb} ${namesOf(changedSegments())}`,
    message: () => trackMessage('changed'),
  },
  trackThis: {
    also: 'solve segment current run',
    label: () => `${words().verb} this segment`, icon: 'mid', keys: ['Shift T'], off: whyNotTrackThis,
    run: trackSegment,
  },
  trackAll: {
    also: 'solve everything whole run recompute',
    label: () => `${words().verb} all ${count(chosenSegments().length, 'segment')}${chosenTail()}`, icon: 'reset',
    off: whyNotTrackChosen, message: () => trackMessage('all'),
  },
  stand: {
    also: 'floor ground contacts feet pins plant foot slide soles level up',
    label: 'Stand on the floor', icon: 'floor', keys: ['Shift F'], off: whyNotStand,
    title: 'Pin the feet where they stand, on one floor. Keyframes stay exact in the picture and give way in depth',
    message: () => ({ do: 'stand' }),
  },
  lift: {
    also: 'up horizon level redraft lift',
    label: 'Draft anew for this up direction', icon: 'wand', off: whyNotLift, title: liftWords,
    message: () => ({ do: 'lift' }),
  },
  findUp: {
    also: 'horizon level tilt gravity vertical lines vanishing',
    label: 'Find the up direction', icon: 'wand', off: whyNotFindUp,
    title: 'By upright lines in the picture, and where it is tracked by how the person stands and where',
    message: () => ({ do: 'find_up' }),
  },
  levelCamera: {
    also: 'horizon tilt up gravity straight',
    label: 'The camera is level', icon: 'mid', title: 'It looks straight ahead, neither up nor down',
    off: () => (server.camera ? '' : 'Open a video first'), message: () => ({ do: 'level_camera' }),
  },
  trackAhead: {
    label: 'Track ahead', icon: 'ahead', keys: ['A'], row: 'Track ahead, back', off: () => whyNotAhead('forward'),
    title: 'Follow the body on from the last keyframe, as far as it is seen well',
    message: () => ({ do: 'track_ahead', direction: 'forward' }),
  },
  trackBack: {
    label: 'Track back', icon: 'back', keys: ['Shift A'], row: 'Track ahead, back', off: () => whyNotAhead('backward'),
    title: 'Follow the body back from the first keyframe, as far as it is seen well',
    message: () => ({ do: 'track_ahead', direction: 'backward' }),
  },
  drawBox: {
    also: 'detect person automatic pose estimation draft another other person actor',
    label: 'Draw a box around the person', icon: 'crop', keys: ['B'], row: 'Draft from a box', off: whyNotDrawBox,
    title: 'Show which person to find: poses for every frame are drafted from it', run: () => setUi('tool', 'box'),
  },
  draft: {
    also: 'automatic auto detect pose estimation markerless ai',
    label: draftLabel, icon: 'wand', off: whyNotDraft,
    title: () => ['Find the person in every frame and pose the body there', draftTimeWords()].filter(Boolean).join('. '), message: draftMessage,
  },
  draftRest: {
    also: 'automatic auto detect remaining continue resume', alone: 'Draft the remaining frames',
    label: () => `Draft the remaining ${count(restCount(), 'frame')}`, icon: 'wand', off: whyNotDraftRest,
    title: () => ['Those that the draft was cancelled before', draftTimeWords(restCount())].filter(Boolean).join('. '), message: () => ({ do: 'draft_rest' }),
  },
  reduce: {
    also: 'unbake bake keyframe reduction decimate simplify sparse fewer thin key reducer optimise optimize curve',
    label: 'Reduce to keyframes…', icon: 'mid', off: whyNotReduce,
    title: 'A few keyframes to edit the motion by, which stays as it is between them; between the in and the out point',
    run: beginReduction,
  },
  cancel: {
    also: 'stop abort tracking', alone: 'Cancel what is running',
    label: 'Cancel', icon: 'x', keys: ['Escape'], handledBy: 'escape',
    off: () => (server.job?.state === 'running' ? '' : 'Nothing is running'), message: () => ({ do: 'cancel' }),
  },
  live: {
    also: 'auto track realtime automatic',
    label: () => `${words().verb} while posing`, keys: ['L'],
    title: () => `${words().verb} the neighbouring segments at each move of a keyframe`,
    on: () => Boolean(server.view?.live), message: () => ({ do: 'live', on: !server.view?.live }),
  },
  nextProblem: {
    also: 'error warning check lost review worst issue',
    label: 'Next problem', keys: ['Shift N'],
    title: (state) => ({ check: 'Go to the next segment to check', lost: 'Go to the next lost segment' })[state],
    off: (state) => (problems(state).length ? '' : 'No segment needs attention'), run: nextProblem,
  },
  search: {
    also: 'command palette find menu actions',
    label: 'Search commands', icon: 'find', keys: ['Ctrl K'], always: true, run: () => toggleSearch(),
  },
  showKeys: {
    label: 'Keys and help', icon: 'help', keys: ['?'], always: true, run: toggleSheet,
    also: 'shortcuts hotkeys keyboard help cheat sheet manual',
  },
};
