// What a person may type into a number field.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { read, shortNumber } from '../../static/controls/arithmetic.js';

const valueOf = (text, shown = 10, unit = '') => read(text, shown, unit).value;
const near = (actual, expected) => assert.ok(Math.abs(actual - expected) < 1e-9, `${actual} ≠ ${expected}`);

test('a plain number is taken, with a point or a comma', () => {
  for (const text of ['96', ' 96 ', '96.0', '96,0']) assert.equal(valueOf(text), 96);
  assert.equal(valueOf('1,5'), 1.5);
  assert.equal(valueOf('.5'), 0.5);
  assert.equal(valueOf('2e3'), 2000);
  assert.equal(valueOf('2e-1'), 0.2);
});

test('a leading minus is a negative number, not a difference', () => {
  assert.equal(valueOf('-5'), -5);
  assert.equal(valueOf('−5'), -5);
  assert.equal(valueOf('–5'), -5);
});

test('a sign before the number goes on from where the field stands', () => {
  assert.equal(valueOf('+5'), 15);
  assert.equal(valueOf('+=5'), 15);
  assert.equal(valueOf('-=4'), 6);
  assert.equal(valueOf('*3'), 30);
  assert.equal(valueOf('*=3'), 30);
  assert.equal(valueOf('/4'), 2.5);
  assert.equal(valueOf('/=4'), 2.5);
  assert.equal(valueOf('×2'), 20);
  assert.equal(valueOf('·2'), 20);
  assert.equal(valueOf('÷2'), 5);
});

test('a sum is worked out, products before sums and brackets before both', () => {
  assert.equal(valueOf('30/2'), 15);
  assert.equal(valueOf('1+2*3'), 7);
  assert.equal(valueOf('(1+2)*3'), 9);
  assert.equal(valueOf('10-4-3'), 3);
  assert.equal(valueOf('16/4/2'), 2);
  assert.equal(valueOf('2*-3'), -6);
  assert.equal(valueOf('-(2+3)'), -5);
  assert.equal(valueOf('*2+1'), 30);
});

test('lengths of another unit are converted to that of the field', () => {
  near(valueOf('1.78 m', 0, 'cm'), 178);
  near(valueOf('25mm', 0, 'cm'), 2.5);
  near(valueOf('5 cm', 0, 'm'), 0.05);
  near(valueOf('+=1m', 10, 'cm'), 110);
  near(valueOf('*2 m', 10, 'cm'), 20); // a factor has no length
  assert.equal(valueOf('90°', 0, '°'), 90);
  assert.equal(valueOf('90 deg', 0, '°'), 90);
  assert.equal(valueOf('3 m', 0, '°'), 3);
});

test('what is no number is refused in one sentence that repeats it', () => {
  for (const text of ['wide', '1+', '(1', '1)', '2 3', '1..2', 'alert(1)', '()', '*']) {
    assert.deepEqual(read(text, 10), { words: `“${text}” is not a number.` });
  }
  assert.deepEqual(read('  ', 10), { words: 'A number is missing.' });
  assert.match(read('1/0', 10).words, /zero/);
  assert.match(read('/0', 10).words, /zero/);
});

test('numbers are written with a true minus sign and never as minus zero', () => {
  assert.equal(shortNumber(-1.25, 1), '−1.3');
  assert.equal(shortNumber(3, 2), '3.00');
  assert.equal(shortNumber(-0.04, 1), '0.0');
  assert.equal(shortNumber(-0.4, 0), '0');
  assert.equal(shortNumber(-0.06, 1), '−0.1');
});
