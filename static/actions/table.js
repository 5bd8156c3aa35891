// Everything that one can do at the page, in one table: what it is called, its keys, when it can be
// done and how. The keyboard, the sheet of keys, menus, buttons and their tips are made from it.

import { openChooser, toggleSearch, toggleSheet } from '../controls/dialogs.js';
import { toggleMenu } from '../controls/menu.js';
import { partNamed, selectedPart } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { words } from '../store/subject.js';
import { fitLarge, showLarge, VIEW_KEYS, VIEW_NAMES } from '../views/views.js';
import { count } from '../controls/words.js';
import { alongChain, endOfChain, otherSide, outward } from './chain.js';
import { askWhatIsMissing, usualOptions } from './exporting.js';
import { copy, copyWords, nothingCopied, pasteWith, whyNotCopy } from './copying.js';
import { draftCount, draftMessage, whyNotDraft, whyNotDrawBox } from './drafting.js';
import {
  FILTER_HZ, copyPath, copyPicture, hasMotion, saveMotion, savePicture, saveReport,
} from './export.js';
import { addKey, copyKey, duplicateKey, whyNotCopyHere } from './keying.js';
import { ringsAreShown } from './keypoints.js';
import { goToStep, noHistory } from './history.js';
import { foldLanes } from './lanes.js';
import { fitsFocal } from './lens.js';
import { noNote, noteAt, toNote, whyNoNote, writeNote } from './notes.js';
import { keyLimb, unkeyMessage, whyNotKeyLimb } from './limbs.js';
import {
  acceptMessage, allPins, beginPin, dismissMessage, endPin, framesOf, isSoft, noProposals, pinHere, pinToFloor,
  proposedPins, togglePin, unpin, whyNoPinHere, whyNotPin,
} from './pins.js';
import {
  frame, goTo, isKey, keyBeside, middle, next, nextProblem, problems, step, suggestedFrame, toFirst, toKey, toLast,
} from './playhead.js';
import { clearSpan, playBack, playFaster, playSlower, setIn, setOut, stop, toggleLoop, togglePlaying, whyNotClear, whyNotPlay } from './playing.js';
import { insertTitle, keepMessage, whyNotInsert, whyNotKeep } from './poses.js';
import { addPart, carrier, deleteTitle, whyNotDeletePart } from './parts.js';
import {
  atFirst, atLast, hasNoChild, isRoot, noKeyframe, noOtherSide, whyNotFitPose, whyNotFitSizes, whyNotSwap,
} from './reasons.js';
import { chooseImport } from './importing.js';
import { beginReduction, whyNotReduce } from './reducing.js';
import { answer, goal, isReviewing, places, toggleReview, turn, whyNoPlace, whyNotReview } from './review.js';
import { deleteAny, deleteLabel, nudge, selectAll, selectHere, whyNotDeleteAny, whyNotNudge, whyNotSelect, whyNotSelectAll } from './selection.js';
import { chooseTheme, chosenTheme } from './theme.js';
import {
  changedSegments, namesOf, trackSegment, whyNotAhead, whyNotTrack, whyNotTrackChanged, whyNotTracked, whyNotTrackThis,
} from './tracking.js';
import { isZoomed, zoomTo, zoomToInterval } from './window.js';

/**
 * A text, or one made of the state and of what it is about, such as a frame or a segment.
 * @typedef {string | ((about?: any) => string)} Text
 */

/**
 * One thing that can be done: by a message to the server, or by a function of the page.
 * @typedef {object} Action
 * @property {Text} label  in menus, on buttons, to screen readers and on the sheet of keys
 * @property {Text} [title]  the tip, where the label does not say enough
 * @property {Text} [icon]
 * @property {string[]} [keys]  chords as "Ctrl Shift Z"; the first is shown beside the label
 * @property {string[]} [aliases]  chords that work as well and are shown nowhere
 * @property {string} [row]  on the sheet of keys; neighbours with the same words share a line
 * @property {(about?: any) => string} [off]  why it cannot be done now, or ''
 * @property {(about?: any) => boolean} [on]  whether it is switched on, or the one that is chosen
 * @property {(about?: any) => { do: string }} [message]
 * @property {(...about: any[]) => unknown} [run]
 * @property {boolean} [repeats]  while its key stays down; where it leads nowhere, nothing is said
 * @property {boolean} [always]  also while no file is open
 * @property {'drag' | 'pointer' | 'escape' | 'release' | 'review' | 'playing' | 'paste'} [heard]  by whom its keys are
 *   heard, if not by the keyboard's table: by a drag, by a view, by Esc in its order, when Space is let go, by the
 *   review, while it plays, by what the browser tells of its clipboard
 */

const REPEATS = { repeats: true };

/** @satisfies {Record<string, Action>} */
const FRAMES = {
  previousFrame: {
    label: 'Back one frame', icon: 'sb', keys: ['ArrowLeft'], row: 'One frame', ...REPEATS,
    off: atFirst, run: () => step(-1),
  },
  nextFrame: {
    label: 'Forward one frame', icon: 'sf', keys: ['ArrowRight'], row: 'One frame', ...REPEATS,
    off: atLast, run: () => step(1),
  },
  tenBack: {
    label: 'Back ten frames', keys: ['Shift ArrowLeft'], row: 'Ten frames', ...REPEATS,
    off: atFirst, run: () => step(-10),
  },
  tenForward: {
    label: 'Forward ten frames', keys: ['Shift ArrowRight'], row: 'Ten frames', ...REPEATS,
    off: atLast, run: () => step(10),
  },
  firstFrame: {
    label: 'First frame', icon: 'first', keys: ['Home'], row: 'First, last frame', ...REPEATS,
    off: atFirst, run: toFirst,
  },
  lastFrame: {
    label: 'Last frame', icon: 'last', keys: ['End'], row: 'First, last frame', ...REPEATS,
    off: atLast, run: toLast,
  },
  play: {
    label: () => (ui.playing ? 'Stop' : 'Play'), icon: () => (ui.playing ? 'pause' : 'play'),
    keys: ['Space'], row: 'Play, stop', heard: 'release',
    off: whyNotPlay, run: togglePlaying,
  },
  playBack: { label: 'Play backward', keys: ['Shift Space'], off: whyNotPlay, run: playBack },
  playSlower: { label: 'Slower, then backward', keys: ['J'], row: 'Shuttle while playing', heard: 'playing', run: playSlower },
  stopPlaying: { label: 'Stop', keys: ['K'], row: 'Shuttle while playing', heard: 'playing', run: stop },
  playFaster: { label: 'Faster', keys: ['L'], row: 'Shuttle while playing', heard: 'playing', run: playFaster },
  loop: {
    label: 'Loop', icon: 'repeat', title: 'Play again and again', keys: ['Shift L'], on: () => Boolean(ui.loop), run: toggleLoop,
  },
  setIn: { label: 'In point here', icon: 'in', keys: ['Shift I'], row: 'In, out point here', title: 'Playing begins at this frame', run: () => setIn() },
  setOut: { label: 'Out point here', icon: 'out', keys: ['Shift O'], row: 'In, out point here', title: 'Playing ends at this frame', run: () => setOut() },
  clearSpan: { label: 'Clear in and out point', icon: 'x', keys: ['Shift X'], off: whyNotClear, run: clearSpan },
  previousKeyframe: {
    label: 'Previous keyframe', icon: 'pk', keys: [','], row: 'Previous, next keyframe', ...REPEATS,
    off: () => noKeyframe(-1), run: () => toKey(-1),
  },
  nextKeyframe: {
    label: 'Next keyframe', icon: 'nk', keys: ['.'], row: 'Previous, next keyframe', ...REPEATS,
    off: () => noKeyframe(1), run: () => toKey(1),
  },
  middle: { label: 'Middle of this interval', icon: 'mid', keys: ['/'], run: middle },
  suggestedFrame: {
    label: 'Go to the suggested frame', keys: ['N'],
    off: () => (suggestedFrame() === null ? 'No frame is suggested' : ''), run: next,
  },
  zoomToInterval: { label: 'Zoom to this interval', icon: 'grow', keys: ['Z'], on: isZoomed, run: zoomToInterval },
  zoomToSegment: { label: 'Zoom to segment', icon: 'grow', run: ({ first, last }) => zoomTo(first, last) },
  goTo: { label: (to) => `Go to frame ${to}`, icon: 'flag', run: goTo },
};

/** @satisfies {Record<string, Action>} */
const NOTES = {
  note: {
    label: (at) => (noteAt(at) ? 'Edit note' : 'Add note'), icon: 'note', keys: ['Shift M'], row: 'Note at this frame', run: writeNote,
    title: (at) => (noteAt(at) ? 'Edit the note at this frame' : 'Write a note at this frame, or leave a flag'),
  },
  deleteNote: {
    label: 'Delete note', icon: 'trash', off: whyNoNote,
    message: (at = frame()) => ({ do: 'delete_note', frame: at }),
  },
  notes: {
    label: 'All notes', icon: 'note', off: () => (server.notes?.length ? '' : 'There are no notes'), run: () => toggleSearch('Note'),
  },
  previousNote: {
    label: 'Previous note', icon: 'flag', keys: ['Shift H'], row: 'Previous, next note', ...REPEATS,
    off: () => noNote(-1), run: () => toNote(-1),
  },
  nextNote: {
    label: 'Next note', icon: 'flag', keys: ['H'], row: 'Previous, next note', ...REPEATS,
    off: () => noNote(1), run: () => toNote(1),
  },
};

/** @satisfies {Record<string, Action>} */
const POSE = {
  addKeyframe: { label: 'Add keyframe', icon: 'key', keys: ['K'], run: addKey },
  keyLimb: {
    label: 'Key this limb only', icon: 'part', keys: ['Shift K'], off: whyNotKeyLimb,
    title: 'The limb is exact at this frame, the rest of the body stays with the tracker', run: keyLimb,
  },
  keyWhole: { label: 'Key the whole pose', icon: 'key', message: (at = frame()) => ({ do: 'add_key', frame: at }) },
  unkeyLimb: { label: (about) => `Leave the ${about?.label?.toLowerCase() ?? 'limb'} to the tracker`, icon: 'x', message: unkeyMessage },
  deleteKeyframe: { label: deleteLabel, icon: 'key', keys: ['Delete'], row: 'Delete keyframes', off: whyNotDeleteAny, run: deleteAny },
  duplicateKeyframe: { label: 'Duplicate to frame', icon: 'copy', run: duplicateKey },
  selectAllKeyframes: { label: 'Select all keyframes', keys: ['Ctrl A'], off: whyNotSelectAll, run: selectAll },
  selectKeyframe: {
    label: 'Select this keyframe', title: 'One more or one less', keys: ['Shift S'], off: whyNotSelect, run: selectHere,
  },
  selectRange: { label: 'Range, one more', keys: ['Shift Click', 'Ctrl Click'], heard: 'pointer' },
  earlier: nudging(-1, 'ArrowLeft'),
  later: nudging(1, 'ArrowRight'),
  tenEarlier: nudging(-10, 'Shift ArrowLeft'),
  tenLater: nudging(10, 'Shift ArrowRight'),
  fitPose: {
    label: 'Fit pose', icon: 'wand', keys: ['F'], off: whyNotFitPose,
    title: () => `Refine the pose to match the ${words().image}`,
    message: () => ({ do: 'fit_here' }),
  },
  fitSizes: {
    label: 'Fit sizes', icon: 'wand', off: whyNotFitSizes,
    title: () => `Estimate the body’s sizes from all ${count(server.keys?.frames.length ?? 0, 'keyframe')}`,
    message: () => ({ do: 'fit_sizes', focal: fitsFocal() }),
  },
  useTracked: {
    label: () => `Use ${words().done} pose`, icon: 'take', off: whyNotTracked,
    title: () => `Replace this frame’s pose with the ${words().done} one`,
    message: () => ({ do: 'take_tracked' }),
  },
  copyPose: {
    label: copyWords, icon: 'copy', keys: ['Ctrl C'], row: 'Copy, paste', off: whyNotCopy,
    title: 'Copy the selected keyframes, else the pose at this frame', run: copy,
  },
  pastePose: {
    label: 'Paste', icon: 'paste', keys: ['Ctrl V'], row: 'Copy, paste', heard: 'paste', off: nothingCopied,
    title: 'Paste the copied pose here, or the copied keyframes from this frame on', run: () => pasteWith({}),
  },
  pasteMirrored: {
    label: 'Paste mirrored', icon: 'mirror', keys: ['Ctrl Shift V'], heard: 'paste', off: nothingCopied,
    title: 'Paste with left and right swapped', run: () => pasteWith({ mirrored: true }),
  },
  pasteOnto: {
    label: 'Paste onto the body here', icon: 'paste', keys: ['Shift V'], off: nothingCopied,
    title: 'Paste where the body stands at this frame, not where it was copied', run: () => pasteWith({ onto_body: true }),
  },
  keepPose: {
    label: 'Keep in the pose library', icon: 'plus', title: 'Keep the pose of this frame for every session', off: whyNotKeep,
    message: keepMessage,
  },
  insertPose: {
    label: (pose) => `Insert ${pose?.name ?? 'a kept pose'}`, title: insertTitle, off: whyNotInsert,
    message: ({ id }) => ({ do: 'insert_pose', id }),
  },
  insertMirrored: {
    label: (pose) => `Insert ${pose?.name ?? 'a kept pose'} mirrored`, icon: 'mirror', off: whyNotInsert,
    message: ({ id }) => ({ do: 'insert_pose', id, mirrored: true }),
  },
  copyPrevious: {
    label: () => copyLabel(-1), icon: 'prev', keys: ['P'], row: 'Copy from previous keyframe',
    title: 'Copy the previous keyframe’s pose to this frame',
    off: () => noKeyframe(-1), message: () => copyKey(-1),
  },
  copyNext: {
    label: () => copyLabel(1), icon: 'prev', title: 'Copy the next keyframe’s pose to this frame',
    off: () => noKeyframe(1), message: () => copyKey(1),
  },
  copyKeyHere: {
    label: () => `Copy its pose to frame ${frame()}`, icon: 'take', off: whyNotCopyHere,
    message: (from = frame()) => ({ do: 'copy_key', from_frame: from }),
  },
  swapSides: {
    label: 'Swap left and right', icon: 'loop', off: whyNotSwap,
    title: 'Move the left limbs to where the right ones are seen, and the other way round',
    message: () => ({ do: 'exchange' }),
  },
  turnInDepth: {
    label: 'Turn in depth', icon: 'depth',
    title: () => `${selectedPart()?.label ?? 'The whole body'} points away from the camera instead of toward it, seen where it is`,
    message: (part) => ({ do: 'turn_in_depth', part: part?.name ?? server.view.selected ?? null }),
  },
  addPart: {
    label: 'Add part', icon: 'plus', run: addPart,
    title: (part) => `Add a part at the far end of ${(part ?? carrier())?.label.toLowerCase() ?? 'the body'}`,
  },
  deletePart: {
    label: 'Delete part', icon: 'trash', off: whyNotDeletePart, title: deleteTitle,
    message: (part) => ({ do: 'delete_part', part: part?.name ?? server.view.selected }),
  },
  resetPart: {
    label: 'Reset part', icon: 'reset', keys: ['Backspace'], row: 'Reset part, pose',
    off: (part) => (part ?? server.view?.selected ? '' : 'Select a part first'),
    message: (part) => ({ do: 'reset_part', part: part?.name ?? server.view.selected }),
  },
  resetPose: {
    label: 'Reset pose', icon: 'reset', keys: ['Shift Backspace'], row: 'Reset part, pose',
    message: () => ({ do: 'reset_pose' }),
  },
  undo: {
    label: () => stepLabel('Undo', server.undo?.undo), icon: 'undo', keys: ['Ctrl Z'], row: 'Undo, redo', ...REPEATS,
    off: () => (server.undo?.undo ? '' : 'Nothing to undo'), message: () => ({ do: 'undo' }),
  },
  history: {
    label: 'History', icon: 'old', title: 'All steps that can be undone or redone', off: noHistory,
    run: () => toggleMenu('history'),
  },
  goToStep: { label: 'Go to this step', icon: 'old', run: goToStep },
  redo: {
    label: () => stepLabel('Redo', server.undo?.redo), icon: 'redo', keys: ['Ctrl Shift Z'], aliases: ['Ctrl Y'],
    row: 'Undo, redo', ...REPEATS,
    off: () => (server.undo?.redo ? '' : 'Nothing to redo'), message: () => ({ do: 'redo' }),
  },
};

/** @satisfies {Record<string, Action>} */
const PINS = {
  pin: {
    label: (part) => (pinHere(part) === undefined ? 'Pin here from this frame' : 'Unpin'), icon: 'anchor', keys: ['Shift P'],
    row: 'Pin, unpin hand or foot', off: whyNotPin, run: togglePin,
    title: 'The part stays in its place as long as it stands still around this frame',
  },
  pinCorner: {
    label: 'Pin this corner', icon: 'anchor', title: 'The corner stays in its place around this frame',
    message: ({ part, at }) => ({ do: 'set_pin', part, frame: frame(), corner: at }),
  },
  pinToFloor: { label: 'Pin to floor', icon: 'down', off: whyNotPin, run: pinToFloor },
  beginPin: { label: 'Begin the pin at this frame', icon: 'mid', off: whyNoPinHere, run: beginPin },
  endPin: { label: 'End the pin at this frame', icon: 'mid', off: whyNoPinHere, run: endPin },
  unpin: {
    label: 'Unpin', icon: 'x', off: (index) => (allPins()[index ?? pinHere()] ? '' : whyNoPinHere()),
    title: (index) => unpinTitle(allPins()[index ?? pinHere()]), run: unpin,
  },
  acceptPins: {
    label: (pin) => (pin || proposedPins().length === 1 ? 'Accept' : `Accept all ${proposedPins().length}`), icon: 'check', off: noProposals,
    message: acceptMessage,
  },
  dismissPins: {
    label: 'Dismiss', icon: 'x', title: 'They come back after the next tracking', off: noProposals, message: dismissMessage,
  },
  softKey: {
    label: (at) => (isSoft(at) ? 'Make the keyframe exact' : 'Soften the keyframe'), icon: 'key',
    title: 'A soft keyframe gives way in depth to pins and smoothness',
    off: (at = frame()) => (isKey(at) ? '' : `Frame ${at} is not a keyframe`),
    message: (at = frame()) => ({ do: isSoft(at) ? 'exact_key' : 'soften_key', frame: at }),
  },
  splitPin: {
    label: 'Split the pin', icon: 'mid', title: 'Two places instead of one, the second from this keyframe on',
    message: ({ index, frame: at } = { index: 0, frame: frame() }) => ({ do: 'split_pin', index, frame: at }),
  },
  partMenu: { label: 'Menu of a part', keys: ['Right-click', 'Menu'], heard: 'pointer' },
};

/** @satisfies {Record<string, Action>} */
const TRACK = {
  trackChanged: {
    label: () => `${words().verb} changed segments`, icon: 'track', keys: ['T'], off: whyNotTrackChanged,
    title: () => `${words().verb} ${namesOf(changedSegments())}`,
    message: () => ({ do: 'track', what: 'changed' }),
  },
  trackThis: {
    label: () => `${words().verb} this segment`, icon: 'mid', keys: ['Shift T'], off: whyNotTrackThis,
    run: trackSegment,
  },
  trackAll: {
    label: () => `${words().verb} all ${count((server.segments ?? []).length, 'segment')}`, icon: 'reset',
    off: whyNotTrack, message: () => ({ do: 'track', what: 'all' }),
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
    label: 'Draw a box around the person', icon: 'crop', keys: ['B'], row: 'Draft from a box', off: whyNotDrawBox,
    title: 'Show which person to find: poses for every frame are drafted from it', run: () => setUi('tool', 'box'),
  },
  draft: {
    label: () => `Draft ${count(draftCount(), 'frame')}`, icon: 'wand', off: whyNotDraft,
    title: 'Find the person in every frame and pose the body there', message: draftMessage,
  },
  reduce: {
    label: 'Reduce to keyframes…', icon: 'mid', off: whyNotReduce,
    title: 'The fewest keyframes that give the motion back to a tolerance, between the in and the out point',
    run: beginReduction,
  },
  cancel: {
    label: 'Cancel', icon: 'x', keys: ['Escape'], heard: 'escape',
    off: () => (server.job?.state === 'running' ? '' : 'Nothing is running'), message: () => ({ do: 'cancel' }),
  },
  live: {
    label: () => `${words().verb} while posing`, keys: ['L'],
    title: () => `${words().verb} the neighbouring segments each time a keyframe changes`,
    on: () => Boolean(server.view?.live), message: () => ({ do: 'live', on: !server.view?.live }),
  },
  nextProblem: {
    label: 'Next problem', keys: ['Shift N'],
    title: (state) => ({ check: 'Go to the next segment to check', lost: 'Go to the next lost segment' })[state],
    off: (state) => (problems(state).length ? '' : 'No segment needs attention'), run: nextProblem,
  },
  search: {
    label: 'Search commands', icon: 'find', keys: ['Ctrl K'], always: true, run: () => toggleSearch(),
  },
  showKeys: { label: 'Keys and help', icon: 'help', keys: ['?'], always: true, run: toggleSheet },
};

/** @satisfies {Record<string, Action>} */
const REVIEW = {
  review: {
    label: 'Review', icon: 'flag', keys: ['Shift R'], on: isReviewing, off: whyNotReview, run: toggleReview,
    title: () => `Look at the places expected to be off by more than ${goal()} px, the worst first`,
  },
  acceptPlace: {
    label: 'Accept', title: 'The motion is right here', keys: ['Enter'], row: 'In review: accept, cannot tell', heard: 'review', off: whyNoPlace,
    run: () => answer('accepted'),
  },
  nextPlace: { label: 'Next', title: 'Look at the next place, and at this one later', keys: ['N'], row: 'In review: next, previous', heard: 'review', off: whyNoPlace, run: () => turn(1) },
  previousPlace: { label: 'Previous', keys: ['Shift N'], row: 'In review: next, previous', heard: 'review', off: whyNoPlace, run: () => turn(-1) },
  cannotTell: {
    label: 'Cannot tell', title: 'The picture does not show it: leave this place open and do not ask again', keys: ['Shift Enter'],
    row: 'In review: accept, cannot tell', heard: 'review', off: whyNoPlace, run: () => answer('unclear'),
  },
  continueReview: {
    label: 'Continue', icon: 'flag', title: () => `Review: ${count(places().length, 'place')} left`, off: whyNotReview, run: toggleReview,
  },
};

/** @satisfies {Record<string, Action>} */
const TOOLS = {
  select: { label: 'Select', icon: 'sel', keys: ['V'], ...tool('select') },
  rotate: { label: 'Rotate', icon: 'rot', keys: ['R'], ...tool('rotate') },
  move: { label: 'Move body', title: 'Move or turn the whole body, hands and feet go along', icon: 'move', keys: ['G'], ...tool('move') },
  ends: { label: 'Drag hands and feet', icon: 'ik', keys: ['E'], ...tool('ends') },
  size: { label: 'Sizes', icon: 'size', keys: ['S'], ...tool('size') },
  pan: { label: 'Pan and zoom', icon: 'hand', ...tool('pan') },
  otherSide: {
    label: 'Other side of the body', icon: 'mirror', keys: ['Q'], ...REPEATS, off: noOtherSide, run: otherSide,
  },
  inward: {
    label: () => towards('body', partNamed(selectedPart()?.parent)), icon: 'sb', keys: ['['], row: 'Along the limb',
    ...REPEATS, off: isRoot, run: () => alongChain(-1),
  },
  outward: {
    label: outwardLabel, icon: 'sf', keys: [']'],
    row: 'Along the limb', ...REPEATS, off: hasNoChild, run: () => alongChain(1),
  },
};

/** @satisfies {Record<string, Action>} */
const VIEW = {
  mainView: large('main'),
  topView: large('top'),
  sideView: large('side'),
  frontView: large('front'),
  allViews: { label: 'All four views', keys: ['5'], run: () => showLarge('quad') },
  freeView: { label: 'Free view', keys: ['6'], run: () => showLarge('free') },
  orbitView: { label: 'Orbit the free view', keys: ['Right drag'], heard: 'pointer' },
  wire: mode('Wire'),
  solid: mode('Solid'),
  both: mode('Both'),
  nextMode: {
    label: 'Wire, solid, both', keys: ['W'],
    message: () => ({ do: 'display', mode: nextOf(['wire', 'solid', 'both'], server.view.mode) }),
  },
  ghosts: {
    label: 'Ghosts of the neighbouring keyframes', icon: 'ghost', keys: ['O'], row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.ghosts), message: () => ({ do: 'display', ghosts: !server.view.ghosts }),
  },
  trail: {
    label: 'Motion trail', icon: 'trail', keys: ['M'], row: 'Ghosts, trail, lanes',
    on: () => Boolean(server.view?.trail), message: () => ({ do: 'display', trail: !server.view.trail }),
  },
  rings: {
    label: 'Show rings', icon: 'rings', title: 'Keypoints on the picture: drag one to correct it',
    on: ringsAreShown, run: () => setUi('rings', !ringsAreShown()),
  },
  floor: {
    label: 'Floor', icon: 'floor', title: 'Floor in the camera view, cells of 25 cm',
    on: () => Boolean(server.view?.floor), message: () => ({ do: 'display', floor: !server.view.floor }),
  },
  lanes: {
    label: () => (ui.lanes ? 'Collapse the lanes' : 'Show all lanes'), icon: 'chev', keys: ['I'],
    row: 'Ghosts, trail, lanes', run: foldLanes,
  },
  fitView: { label: 'Fit view', keys: ['0'], run: fitLarge },
  panView: { label: 'Pan', keys: ['Space drag'], row: 'Pan, zoom', heard: 'pointer' },
  zoomView: { label: 'Zoom', keys: ['Wheel'], row: 'Pan, zoom', heard: 'pointer' },
  saveImage: { label: 'This view, PNG', icon: 'img', keys: ['Shift E'], row: 'Save, copy image', run: () => savePicture() },
  copyImage: { label: 'Copy this view', icon: 'clip', keys: ['Shift C'], row: 'Save, copy image', run: copyPicture },
  saveAllImages: { label: 'All four views, PNG', icon: 'quad', run: () => savePicture('all') },
};

/**
 * Keys pressed while something is dragged: they do nothing by themselves.
 * @satisfies {Record<string, Action>}
 */
const DRAGGING = {
  fine: { label: 'Fine, one tenth', keys: ['Shift'], heard: 'drag' },
  snapAngle: { label: '5° steps', keys: ['Ctrl'], row: '5° or 1 cm steps', heard: 'drag' },
  snapLength: { label: '1 cm steps', keys: ['Ctrl'], row: '5° or 1 cm steps', heard: 'drag' },
  depth: { label: 'Nearer or farther', keys: ['D'], heard: 'drag' },
  carry: { label: 'Take the rest along', keys: ['Alt'], heard: 'drag' },
  free: { label: 'Ignore joint limits', keys: ['U'], heard: 'drag' },
  oneAxis: { label: 'One axis', keys: ['X', 'Y', 'Z'], heard: 'drag' },
  cancelDrag: { label: 'Cancel', keys: ['Escape'], heard: 'drag' },
};

/** The file formats of motion; what writes them is in `app/export/motion_formats.py`. Those that are rigged have bones;
 * what some need is an extra of the same name. */
export const MOTION = {
  saveBvh: { ...motion('bvh', 'bone', 'Blender, MotionBuilder, Daz'), rigged: true },
  saveGlb: { ...motion('glb', 'both', 'Blender, Unreal, Unity, web'), rigged: true },
  saveUsd: { ...motion('usd', 'both', 'Omniverse, Houdini, Maya'), rigged: true, needs: 'usd-core' },
  saveTrc: motion('trc', 'trail', 'OpenSim'),
  saveMot: motion('mot', 'rot', 'OpenSim joint angles'),
  saveC3d: { ...motion('c3d', 'ghost', 'motion laboratories'), needs: 'ezc3d' },
  saveCsv: motion('csv', 'copy', 'joints, angles, verdicts'),
  saveNpz: motion('npz', 'quad', 'NumPy'),
  saveAmass: motion('amass', 'ghost', 'SMPL, motion research'),
  saveCamera: { ...motion('camera', 'camcorder', 'rotomation, JSON'), label: 'Camera' },
  saveChan: motion('chan', 'camcorder', 'the camera for Nuke'),
};

/** Why nothing can be done with a whole session: none is open, and none is meant. */
const whichSession = (session = server.file) => (session ? '' : 'Open a session first');

/** @satisfies {Record<string, Action>} */
const FILE = {
  openFile: { label: 'Open…', icon: 'folder', run: () => openChooser('any') },
  importFile: {
    label: 'Import…', icon: 'up', title: 'Motion, 2D keypoints or a camera from another program', run: chooseImport,
  },
  openRecent: { label: (recent) => recent.name, icon: 'film', message: ({ id }) => ({ do: 'open', kind: 'recent', id }) },
  renameSession: { label: 'Rename', icon: 'pen', always: true, off: whichSession, run: ({ id } = server.file) => setUi('renaming', id) },
  duplicateSession: {
    label: 'Duplicate', icon: 'copy', title: 'A copy for another try on the same video', always: true, off: whichSession,
    message: ({ id } = server.file) => ({ do: 'duplicate_session', id }),
  },
  deleteSession: {
    label: 'Move to the trash', icon: 'trash', title: 'The video stays', always: true, off: whichSession,
    message: ({ id } = server.file) => ({ do: 'delete_session', id }),
  },
  copyPath: { label: 'Copy path', icon: 'copy', run: copyPath },
  closeFile: { label: 'Close', icon: 'x', message: () => ({ do: 'close' }) },
  ...MOTION,
  saveAllMotion: {
    label: 'All formats, ZIP', icon: 'exp',
    off: () => (hasMotion() ? '' : `${words().verb} first: there is no motion yet`), run: () => saveMotion('all'),
  },
  exportFilm: exportDialog('film', 'Film…', 'film'),
  exportImages: exportDialog('pictures', 'Images of all keyframes…', 'img'),
  exportSheet: exportDialog('sheet', 'Keyframe sheet…', 'quad'),
  exportMotion: exportDialog('motion', 'With options…', 'track'),
  filterMotion: {
    label: `Low-pass filter, ${FILTER_HZ} Hz`,
    title: 'Removes faster motion without delay; keyframes move a little',
    on: () => ui.filterMotion === true, run: () => setUi('filterMotion', ui.filterMotion !== true),
  },
  saveReport: {
    label: 'Report, HTML', icon: 'film', run: saveReport,
    off: () => (server.keys?.frames.length ? '' : 'Add a keyframe first'),
  },
  darkTheme: theme('dark', 'Dark', 'moon'),
  lightTheme: theme('light', 'Light', 'sun'),
  systemTheme: theme('auto', 'System', 'both'),
};

/** In the order of the sheet of keys; without a title a group is not on it. */
export const GROUPS = [
  { title: () => 'Frames', actions: { ...FRAMES, ...NOTES } },
  { title: () => 'Pose', actions: { ...POSE, ...PINS } },
  { title: () => words().verb, actions: { ...TRACK, ...REVIEW } },
  { title: () => 'Tools', actions: TOOLS },
  { title: () => 'Views', actions: VIEW },
  { title: () => 'While dragging', actions: DRAGGING },
  { title: null, actions: FILE },
];

export const ACTIONS = { ...FRAMES, ...NOTES, ...POSE, ...PINS, ...TRACK, ...REVIEW, ...TOOLS, ...VIEW, ...DRAGGING, ...FILE };

/** @typedef {keyof typeof ACTIONS} ActionId */

// --- entries that are alike

function nudging(by, chord) {
  const label = `Move selected keyframes ${Math.abs(by) === 1 ? 'one frame' : 'ten frames'} ${by < 0 ? 'earlier' : 'later'}`;
  return {
    label, keys: [`Ctrl ${chord}`], row: Math.abs(by) === 1 ? 'Move selected ones' : 'By ten frames', ...REPEATS,
    off: () => whyNotNudge(by), run: () => nudge(by),
  };
}

function tool(name) {
  return { on: () => ui.tool === name, run: () => setUi('tool', name) };
}

function large(name) {
  const keys = [VIEW_KEYS[name]];
  return { label: `${VIEW_NAMES[name]} view`, keys, row: 'Camera, top, side, front', run: () => showLarge(name) };
}

function mode(label) {
  const name = label.toLowerCase();
  return { label, icon: name, on: () => server.view?.mode === name, message: () => ({ do: 'display', mode: name }) };
}

function motion(format, icon, reader) {
  const off = () => (hasMotion() ? '' : `${words().verb} first: there is no motion yet`);
  return { label: format.toUpperCase(), icon, reader, off, run: () => saveMotion(format) };
}

function exportDialog(what, label, icon) {
  const off = () => (server.keys?.frames.length ? '' : 'Add a keyframe first');
  return { label, icon, off, run: () => openExport(what) };
}

function theme(name, label, icon) {
  return { label, icon, always: true, on: () => chosenTheme() === name, run: () => chooseTheme(name) };
}

function openExport(what) {
  askWhatIsMissing();
  setUi('exporting', { ...usualOptions(), what, ...(ui.exportJob ? { what: ui.exportJob.what } : {}) });
}

const nextOf = (all, one) => all[(all.indexOf(one) + 1) % all.length];

// --- words made of the state

const stepLabel = (word, what) => (what ? `${word} ${what}` : word);

function copyLabel(way) {
  const key = keyBeside(way);
  if (key === undefined) return `Copy from ${way < 0 ? 'previous' : 'next'}`;
  return `Copy from key ${key}`;
}

const unpinTitle = (pin) => (pin ? `Unpin ${pin.label.toLowerCase()}, frames ${framesOf(pin)}` : 'Unpin');

const towards = (end, part) => `Towards the ${end}${part ? `: ${part.label.toLowerCase()}` : ''}`;

function outwardLabel() {
  const part = selectedPart();
  const child = part && outward(part);
  return child ? towards(endOfChain(part).short.toLowerCase(), child) : 'Towards the end of the limb';
}
