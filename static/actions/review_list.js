// The list of a review, as plain values: which rows stand there, which is the current one, what was
// answered. Rows stay where they are until the next N: nothing moves under a pointer.

/** @typedef {import('../store/shapes.js').ReviewPlace} ReviewPlace */
/** @typedef {import('../store/shapes.js').ReviewList} ReviewList */
/** @typedef {import('../store/shapes.js').Answer} Answer */

/** Long enough to see what was corrected; as long as the pointer stays on the body, where another drag
 * may follow, up to three times as long. */
const PAUSE_MS = 400;
const AT_BODY_MS = 1200;

/** How many milliseconds are to wait after a correction, of which some have passed; 0: the list goes on. */
export const pauseLeft = (waited, isAtBody) => (waited < (isAtBody ? AT_BODY_MS : PAUSE_MS) ? PAUSE_MS : 0);

/**
 * The places over a goal: also those of which nobody knows how far they are off.
 * @param {ReviewPlace[]} places
 * @param {number} goal  Pixels.
 */
export const placesAbove = (places, goal) => places.filter(({ px }) => px === null || px > goal);

/**
 * A new list, its worst place first.
 * @param {ReviewPlace[]} places  Those over the goal, ranked.
 * @returns {ReviewList}
 */
export const listOf = (places) => ({ rows: places, current: places[0]?.id ?? null, done: [] });

/** Whether a row has been answered. @param {ReviewList} list */
export const answerOf = (list, id) => list.done.find((one) => one.id === id)?.answer;

/** The rows that wait for an answer. @param {ReviewList} list */
export const openRows = (list) => unanswered(list, list.rows);

/** The places that have no answer in a list. @param {ReviewList} list @param {ReviewPlace[]} places */
export function unanswered(list, places) {
  const ids = new Set(list.done.map(({ id }) => id));
  return places.filter(({ id }) => !ids.has(id));
}

/** @param {ReviewList} list */
export const currentRow = (list) => list.rows.find(({ id }) => id === list.current);

/**
 * With an answer to a row, which stays in its place, and the next open row below it as the current
 * one; null where none of these rows is open any more.
 * @param {ReviewList} list
 * @param {string} id
 * @param {Answer} answer
 * @returns {ReviewList}
 */
export function answered(list, id, answer) {
  const row = list.rows.find((each) => each.id === id);
  if (!row || answerOf(list, id)) return list;
  const after = { ...list, done: [...list.done, { id, frame: row.frame, label: row.label, answer }] };
  if (list.current !== null && list.current !== id) return after; // another one is looked at meanwhile
  return { ...after, current: beside(openRows(after), list.rows, id, 1)?.id ?? null };
}

/**
 * Ranked anew, with the next open place (1) or the previous one (−1) as the current one.
 * @param {ReviewList} list
 * @param {ReviewPlace[]} places  Those over the goal as they are known now.
 * @param {1 | -1} way
 * @returns {ReviewList}
 */
export function turned(list, places, way) {
  const rows = unanswered(list, places);
  const next = list.current === null ? rows[0] : beside(rows, list.rows, list.current, way);
  return { ...list, rows, current: next?.id ?? null };
}

/**
 * Ranked anew while the current row is looked at, which stays what it is.
 * @param {ReviewList} list
 * @param {ReviewPlace[]} places  Those over the goal as they are known now.
 * @returns {ReviewList}
 */
export function ranked(list, places) {
  const row = currentRow(list);
  const open = unanswered(list, places);
  if (!row) return { ...list, rows: open, current: open[0]?.id ?? null };
  const now = presentPlace(open, row);
  return { ...list, rows: now ? open.map((place) => (place === now ? row : place)) : [row, ...open] };
}

/**
 * What a row is about, as it is known now: its limb at that time; undefined where there is nothing to review any more.
 * @param {ReviewPlace[]} places
 * @param {ReviewPlace} row
 */
export const presentPlace = (places, row) =>
  places.find(({ id }) => id === row.id) ?? places.find((place) => isAlike(place, row));

const isAlike = (one, other) =>
  one.kind === other.kind && one.part === other.part && one.first <= other.last && other.first <= one.last;

/**
 * With an answer that is on its way to the server: it counts once the server has it.
 * @param {ReviewList} list
 * @param {string} id
 * @param {Answer} answer
 * @param {number} n  Of its message.
 * @returns {ReviewList}
 */
export const asked = (list, id, answer, n) => ({ ...list, asked: { id, answer, n }, refused: null });

/**
 * The list as it is when the server has done all messages up to a number.
 * @param {ReviewList} list
 * @param {number} done
 * @returns {ReviewList}
 */
export function settled(list, done) {
  if (!list.asked || list.asked.n > done) return list;
  const { id, answer } = list.asked;
  return answered({ ...list, asked: null }, id, answer);
}

/**
 * With an answer that the server has refused: its row stays open, and says why.
 * @param {ReviewList} list
 * @param {number} n  Of the message that was refused.
 * @param {string} words
 * @returns {ReviewList}
 */
export function refused(list, n, words) {
  if (list.asked?.n !== n) return list;
  return { ...list, asked: null, refused: { id: list.asked.id, words } };
}

/** The open row that follows one in its order, or goes before it; round the end. */
function beside(open, rows, id, way) {
  const at = open.findIndex((row) => row.id === id);
  if (at >= 0) return open[(at + way + open.length) % open.length];
  // It is answered or gone: the nearest of its old neighbours that is still open.
  const old = rows.findIndex((row) => row.id === id);
  const order = way > 0 ? [...rows.slice(old + 1), ...rows.slice(0, old)] : [...rows.slice(0, old)].reverse();
  const ids = new Set(open.map((row) => row.id));
  return open.find((row) => row.id === order.find((each) => ids.has(each.id))?.id) ?? open[0];
}

/**
 * Without the answers that were undone: their places are back.
 * @param {ReviewList} list
 * @param {ReviewPlace[]} places  All that are known now.
 * @returns {ReviewList}
 */
export function withUndone(list, places) {
  const back = new Set(places.map(({ id }) => id));
  const done = list.done.filter(({ id }) => !back.has(id));
  if (done.length === list.done.length) return list;
  const undone = list.done.findLast(({ id }) => back.has(id));
  return { ...list, done, current: undone && list.rows.some(({ id }) => id === undone.id) ? undone.id : list.current };
}

/** Rows of which nobody knows how far they are off go by frame. @param {ReviewPlace[]} rows */
export const orderWords = (rows) => (rows.some(({ px }) => px !== null) ? 'worst first' : 'in order of frames');

/** @type {[Answer, string][]} */
const OUTCOMES = [
  ['accepted', 'accepted'],
  ['corrected', 'corrected'],
  ['unclear', 'left open'],
];

/** "3 reviewed: 2 accepted, 1 corrected." @param {ReviewList} list */
export function doneWords({ done }) {
  const many = (answer) => done.filter((one) => one.answer === answer).length;
  const counts = OUTCOMES.filter(([answer]) => many(answer)).map(([answer, word]) => `${many(answer)} ${word}`);
  return `${done.length} reviewed${counts.length ? `: ${counts.join(', ')}` : ''}.`;
}
