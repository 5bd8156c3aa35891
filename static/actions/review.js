// The review: from one place to the next where the motion is least sure. "Accept, correct, go on."

import { chosenFrames } from '../store/clip.js';
import { isCaughtUp } from '../store/edits.js';
import { listen, send } from '../store/link.js';
import { select } from '../store/parts.js';
import { films } from '../store/films.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { isPictureOf, view } from '../views/views.js';
import { toast } from '../controls/toasts.js';
import { frame, goTo, isKey, stopPlaying } from './playhead.js';
import {
  answered,
  answerOf,
  asked,
  currentRow,
  listOf,
  openRows,
  pauseLeft,
  placesAbove,
  presentPlace,
  ranked,
  refused,
  settled,
  turned,
  withUndone,
} from './review_list.js';

/** @typedef {import('../store/shapes.js').ReviewPlace} ReviewPlace */

/** The body takes this share of the view at most: feet and head stay in sight, the more so where it is corrected. */
const BODY_SHARE = 0.85;
/** What its bars leave of the view, px. */
const ROOM = { x: 12, top: 56, bottom: 12 };

/** The window of the picture before the review, and the path of the film it was of. */
let before = null;
/** Where a limb was keyed already when its row became the current one. */
let keyedBefore = '';
/** The row that a keyframe has corrected, after which the list goes on. */
let correctedRow = null;
let timer = 0;
let wasAtWork = false;

export const isReviewing = () => Boolean(ui.review);

/** Where the error is to lie below. */
export const goal = () => ui.reviewGoal ?? server.review?.goal ?? 5;

/** The places over the goal, between the in and the out point where these are set, as they are known now. */
export function places() {
  const [first, last] = chosenFrames() ?? [0, Infinity];
  return placesAbove(server.review?.places ?? [], goal()).filter((one) => first <= one.frame && one.frame <= last);
}

/** The place that is looked at; undefined outside of a review and at its end. @returns {ReviewPlace | undefined} */
export const place = () => (ui.review ? currentRow(ui.review) : undefined);

export function mountReview() {
  watch(['review', 'done'], followAnswers);
  listen('state', settleAnswer);
  listen('refused', refuseAnswer);
  watch(['keys', 'u:dragging'], followKeys);
  watch(['job'], followJob);
  watch(['view', 'u:review', 'u:shown', 'u:unreadable'], () => setUi('placeSeen', Boolean(place() && isSeen(place()))));
  watch(['file'], () => server.file?.path !== before?.path && leave());
}

export const whyNotReview = () => (server.review ? '' : 'Open a video first');

/** Open it where it was left, or close it. */
export function toggleReview() {
  if (isReviewing()) return void closeReview();
  before = { path: server.file?.path, ...windowNow() };
  setUi('reviewLeft', false);
  change(listOf(places()));
}

/** Close it; returns whether it was open. The picture is seen as before. */
export function closeReview() {
  if (!isReviewing()) return false;
  setUi('reviewLeft', places().length > 0);
  putBack();
  leave();
  return true;
}

function leave() {
  clearTimeout(timer);
  setUi('review', null);
  if (before?.path !== server.file?.path) setUi('reviewLeft', false);
}

/** Another goal: ranked anew. */
export function setGoal(px) {
  setUi('reviewGoal', px);
  if (ui.review) change({ ...ui.review, ...listOf(places()), done: ui.review.done });
}

/** What one reads when nothing is left: a lower goal that this film allows; undefined where there is none. */
export const lowerGoal = () => (server.review?.goals ?? []).findLast((px) => px < goal());

// --- answers

export const whyNoPlace = () => (place() ? '' : 'Nothing is left to review');

/** @type {Record<'accepted' | 'unclear', string>} */
const WORDS = { accepted: 'accept_place', unclear: 'cannot_tell' };

/** Whether another frame is looked at than the place's. */
export const isElsewhere = () => Boolean(place()) && place()?.frame !== frame();

/** Whether its own frame is seen yet: the picture, and the body as the server has it there. */
const isSeen = ({ frame: at }) => server.view?.frame === at && isPictureOf(at);

/** Why the place cannot be answered: what is answered is seen. */
export function whyNotAnswer() {
  const row = place();
  if (!row) return whyNoPlace();
  return isElsewhere() || isSeen(row) ? '' : `Frame ${row.frame} is still being loaded`;
}

/** @param {'accepted' | 'unclear'} given */
export function answer(given) {
  const row = place();
  if (!row || isWaiting()) return;
  if (isElsewhere()) return show(row); // what is answered is seen
  // A row that was answered and clicked again has its answer: the list goes on.
  if (answerOf(ui.review, row.id)) return turn(1);
  if (whyNotAnswer()) return; // the same press again answers, once there is something to see
  const now = presentPlace(server.review?.places ?? [], row);
  if (!now) return passGone(row);
  const n = send({ do: WORDS[given], frame: now.frame, part: now.part });
  if (ui.connected) setUi('review', asked(ui.review, row.id, given, n));
  else note(row.id, given);
}

/** Whether an answer is on its way: the list goes on once the server has it. */
const isWaiting = () => Boolean(ui.review?.asked) && ui.connected;

function settleAnswer() {
  if (!ui.review?.asked) return;
  const list = settled(ui.review, server.done ?? 0);
  if (list !== ui.review) goOn(list);
}

function refuseAnswer({ n, words }) {
  if (ui.review) change(refused(ui.review, n, words));
}

/** What was drafted, tracked or deleted meanwhile leaves nothing to answer. */
function passGone(row) {
  toast({
    kind: 'info',
    words: `Nothing is left to review at frame ${row.frame}.`,
    detail: 'It has changed since. The list is up to date again.',
  });
  turn(1);
}

/** To the next place (1), or back to the previous one (−1); the list is ranked anew. */
export function turn(way) {
  if (isWaiting()) return;
  clearTimeout(timer);
  setUi('reviewHeld', null);
  if (ui.review) change(turned(ui.review, places(), way));
}

/** To a row that was clicked. */
export function visit(id) {
  clearTimeout(timer);
  if (ui.review) change({ ...ui.review, current: id });
}

/** To a place that was clicked outside of the list. */
export function visitOrOpen(id) {
  if (!isReviewing()) toggleReview();
  if (!ui.review.rows.some((row) => row.id === id)) turn(1);
  if (ui.review.rows.some((row) => row.id === id)) visit(id);
}

function note(id, what) {
  goOn(answered(ui.review, id, what));
}

/** With its last answer the list is ranked anew. */
function goOn(list) {
  const isLast = openRows(list).length === 0;
  change(isLast ? turned({ ...list, current: null }, places(), 1) : list);
}

function change(list) {
  const was = place()?.id;
  setUi('review', list);
  const row = place();
  if (row && row.id !== was) show(row);
}

/** Go to a place: its frame, its part, and the body large in the picture. */
function show(row) {
  keyedBefore = keyedAt(row.frame);
  correctedRow = null;
  stopPlaying();
  goTo(row.frame);
  select(row.part);
  showBestFilm(row);
  zoomTo(row);
}

/** Beside the first film stands the other one in which the place is seen best. */
function showBestFilm({ id }) {
  const best = server.films_seen?.places[id];
  if (films().some((film) => film.id === best)) setUi('filmLarge', best);
}

// --- what happens meanwhile

/** What was undone is open again. */
function followAnswers() {
  if (!ui.review || !isCaughtUp()) return;
  const list = withUndone(ui.review, server.review?.places ?? []);
  const isOver = list.current === null || !list.rows.length;
  if (isOver && places().length) change(turned(list, places(), 1));
  else if (list !== ui.review) change(list);
}

/** What was tracked or drafted is ranked with the rest, unless the pointer would find another row
 * under it. */
function followJob() {
  const isAtWork = server.job?.state === 'running';
  const isOver = wasAtWork && !isAtWork;
  wasAtWork = isAtWork;
  if (isOver && ui.review && !ui.dragging && !ui.reviewHeld) change(ranked(ui.review, places()));
}

/** A keyframe at the place, of the limb or of all, corrects it; a moment after the last drag the list
 * goes on. */
function followKeys() {
  clearTimeout(timer);
  const row = place();
  if (ui.dragging || !row) return;
  const keyed = keyedAt(row.frame);
  if (keyed !== keyedBefore) correctedRow = keyed ? row.id : null;
  keyedBefore = keyed;
  if (correctedRow === row.id) goOnAfter(row);
}

function goOnAfter(row, waited = 0) {
  const left = pauseLeft(waited, Boolean(ui.hover));
  const act = () => place()?.id === row.id && goOnAfter(row, waited + left);
  if (left) timer = window.setTimeout(act, left);
  else note(row.id, 'corrected');
}

/** What is keyed at a frame, as one text that differs when that does. */
function keyedAt(at) {
  const parts = (server.keys?.parts ?? []).find((key) => key.frame === at)?.parts ?? [];
  return isKey(at) ? 'all' : parts.join(' ');
}

// --- the picture

function windowNow() {
  const { x, y, scale, chosen } = view('main').window;
  return { x, y, scale, chosen, filmLarge: ui.filmLarge ?? null };
}

function putBack() {
  if (!before || before.path !== server.file?.path) return;
  const main = view('main');
  setUi('filmLarge', before.filmLarge);
  if (!before.chosen) return main.fit();
  const { x, y, scale, chosen } = before;
  Object.assign(main.window, { x, y, scale, chosen });
  main.redraw();
}

/** The whole body as large as it can be seen, but no nearer than what its crop shows. */
function zoomTo({ box: [left, top, right, bottom], crop }) {
  const [x, y] = [(left + right) / 2, (top + bottom) / 2];
  const [wide, high] = [Math.max(right - left, crop), Math.max(bottom - top, crop)].map(
    (side) => side / BODY_SHARE / 2,
  );
  const main = view('main');
  main.window.showBox([x - wide, y - high, x + wide, y + high], { ...ROOM, top: belowBars(main.el) });
  main.window.chosen = true;
  main.redraw();
}

/** Where a draft is described, the body stands below it. */
function belowBars(element) {
  const bar = document.getElementById('mdraft')?.getBoundingClientRect();
  return bar ? Math.max(ROOM.top, bar.bottom - element.getBoundingClientRect().top + ROOM.x) : ROOM.top;
}

// --- the keyboard

/** The mode's own keys go before the table's. @type {Record<string, () => void>} */
const KEYS = {
  Enter: () => answer('accepted'),
  'Shift Enter': () => answer('unclear'),
  N: () => turn(1),
  'Shift N': () => turn(-1),
};

/** Whether a drag keys only the limb: at a place to review that is no keyframe. Drafts are posed as a whole. */
export const keysLimb = () => Boolean(place()) && place()?.kind !== 'draft' && !isKey(server.view?.frame);

/** Whether the key was the review's. */
export function onReviewKey(chord, event) {
  const act = isReviewing() && !ui.sheet && !ui.chooser ? KEYS[chord] : undefined;
  if (!act) return false;
  event.preventDefault();
  if (!event.repeat) act();
  return true;
}

/** What the keys do here, for the status bar; null outside of a review. */
export function reviewHints() {
  if (!isReviewing() || ui.dragging || ui.tool === 'box') return null;
  if (!place()) return [['Esc', 'close review']];
  if (isElsewhere()) {
    return [
      ['Enter', `back to frame ${place().frame}`],
      ['N', 'next'],
      ['Shift N', 'previous'],
      ['Esc', 'close review'],
    ];
  }
  return [
    ['Enter', 'accept'],
    ['Drag', place().kind === 'draft' ? 'correct' : 'correct, keys this limb only'],
    ['N', 'next'],
    ['Shift N', 'previous'],
    ['Shift Enter', 'cannot tell'],
    ['Esc', 'close review'],
  ];
}
