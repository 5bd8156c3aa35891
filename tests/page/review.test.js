// The list of a review: what stands where, and what is next.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import './browser.js';
import {
  answered,
  answerOf,
  asked,
  currentRow,
  doneWords,
  listOf,
  openRows,
  orderWords,
  pauseLeft,
  placesAbove,
  presentPlace,
  ranked,
  refused,
  settled,
  turned,
  withUndone,
} from '../../static/actions/review_list.js';

const place = (id, px) => ({ id, frame: Number(id), px });
const PLACES = [place('87', 14), place('34', 9), place('68', 8), place('56', 7), place('21', 6)];
const ids = (list) => list.rows.map(({ id }) => id);

test('a goal keeps what is expected to be off by more, and what nobody knows', () => {
  const some = [place('3', null), place('4', 8), place('5', 5)];
  assert.deepEqual(
    placesAbove(some, 5).map(({ id }) => id),
    ['3', '4'],
  );
});

test('a review begins with the worst place', () => {
  assert.equal(currentRow(listOf(PLACES)).id, '87');
  assert.equal(currentRow(listOf([])), undefined);
});

test('an answer leaves every row where it is and goes on to the next open one', () => {
  const list = answered(listOf(PLACES), '87', 'accepted');
  assert.deepEqual(ids(list), ids(listOf(PLACES)));
  assert.equal(answerOf(list, '87'), 'accepted');
  assert.equal(list.current, '34');
  const skipped = answered({ ...list, current: '56' }, '56', 'unclear');
  assert.equal(skipped.current, '21');
  assert.equal(answered(skipped, '21', 'accepted').current, '34', 'round the end');
});

test('an answer counts once the server has it', () => {
  const list = asked(listOf(PLACES), '87', 'accepted', 12);
  assert.equal(answerOf(list, '87'), undefined);
  assert.equal(list.current, '87');
  assert.equal(settled(list, 11), list);
  const after = settled(list, 12);
  assert.equal(answerOf(after, '87'), 'accepted');
  assert.equal(after.current, '34');
});

test('what the server refuses stays open and says why', () => {
  const list = refused(asked(listOf(PLACES), '87', 'accepted', 12), 12, 'This draft is wrong.');
  assert.equal(list.current, '87');
  assert.equal(settled(list, 12), list, 'it is not counted');
  assert.deepEqual(list.done, []);
  assert.deepEqual(list.refused, { id: '87', words: 'This draft is wrong.' });
  assert.equal(asked(list, '87', 'unclear', 13).refused, null);
});

test('a refusal of anything else leaves the list alone', () => {
  const list = asked(listOf(PLACES), '87', 'accepted', 12);
  assert.equal(refused(list, 11, 'No.'), list);
});

test('an answer counts once', () => {
  const list = answered(listOf(PLACES), '87', 'accepted');
  assert.equal(answered(list, '87', 'corrected'), list);
});

test('with the last answer nothing is current', () => {
  const list = answered(listOf(PLACES.slice(0, 1)), '87', 'corrected');
  assert.equal(list.current, null);
  assert.deepEqual(openRows(list), []);
  assert.equal(turned(list, [], 1).current, null);
});

test('the next N shows the new order, without what was answered', () => {
  const list = answered(listOf(PLACES), '87', 'accepted');
  const worse = [place('40', 20), ...PLACES.slice(1).reverse()];
  const next = turned(list, worse, 1);
  assert.deepEqual(ids(next), ['40', '21', '56', '68', '34']);
  assert.equal(next.current, '40', 'from 34, the last of them, round the end');
  assert.equal(turned(next, worse, -1).current, '34');
});

test('a place that is gone gives way to its old neighbour', () => {
  const list = { ...listOf(PLACES), current: '34' };
  assert.equal(
    turned(
      list,
      PLACES.filter(({ id }) => id !== '34'),
      1,
    ).current,
    '68',
  );
  assert.equal(
    turned(
      list,
      PLACES.filter(({ id }) => id !== '34'),
      -1,
    ).current,
    '87',
  );
});

test('what is undone is open again and becomes the current one', () => {
  const list = answered(answered(listOf(PLACES), '87', 'accepted'), '34', 'corrected');
  assert.equal(withUndone(list, PLACES.slice(2)), list);
  const back = withUndone(list, PLACES.slice(1));
  assert.equal(back.current, '34');
  assert.equal(answerOf(back, '34'), undefined);
  assert.equal(answerOf(back, '87'), 'accepted');
});

test('at the end it says what was answered', () => {
  const list = answered(answered(listOf(PLACES), '87', 'accepted'), '34', 'corrected');
  assert.equal(doneWords(list), '2 reviewed: 1 accepted, 1 corrected.');
});

test('after a correction the list waits a moment, and longer while the pointer is on the body', () => {
  const waits = (isAtBody) => {
    let waited = 0;
    while (pauseLeft(waited, isAtBody)) waited += pauseLeft(waited, isAtBody);
    return waited;
  };
  assert.equal(waits(false), 400);
  assert.equal(waits(true), 1200);
});

test('it goes on when the pointer has left the body meanwhile', () => {
  assert.equal(pauseLeft(400, true), 400);
  assert.equal(pauseLeft(400, false), 0);
});

const spanned = (id, part, first, last, kind = 'tracked') => ({ id, part, first, last, kind, frame: first, px: 8 });

test('what is looked at stays while the list is ranked anew around it', () => {
  const list = { ...listOf(PLACES), current: '34' };
  const worse = [place('40', 20), ...PLACES.filter(({ id }) => id !== '87')];
  assert.deepEqual(ids(ranked(list, worse)), ['40', '34', '68', '56', '21']);
  assert.equal(ranked(list, worse).current, '34');
  const gone = ranked(list, [place('40', 20), place('68', 8)]);
  assert.deepEqual(ids(gone), ['34', '40', '68'], 'also where it is gone');
  assert.equal(gone.current, '34');
  const ended = { ...listOf(PLACES), current: null };
  assert.equal(ranked(ended, worse).current, '40');
  assert.equal(ranked(ended, []).current, null);
});

test('a place tracked anew is the one of its limb at its time, under another frame', () => {
  const row = spanned('72-left_shin', 'left_shin', 70, 76);
  const moved = spanned('74-left_shin', 'left_shin', 74, 79);
  const other = spanned('72-right_shin', 'right_shin', 70, 76);
  assert.equal(presentPlace([other, moved], row), moved);
  assert.equal(presentPlace([other, moved, row], row), row);
  assert.equal(presentPlace([other, spanned('90-left_shin', 'left_shin', 90, 92)], row), undefined);
  const list = ranked({ ...listOf([row]), current: row.id }, [other, moved]);
  assert.deepEqual(list.rows, [other, row], 'what is looked at keeps its frame');
});

test('places go by frame where nobody knows how far any is off, else the worst goes first', () => {
  assert.equal(orderWords(PLACES), 'worst first');
  assert.equal(orderWords([place('3', null), place('9', null)]), 'in order of frames');
  assert.equal(orderWords([...PLACES, place('90', null)]), 'worst first');
});
