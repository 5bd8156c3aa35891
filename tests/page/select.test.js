// What a second click at the same place means, of handles and of what masks have.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { click } from '../../static/handles/select.js';
import { masksIn } from '../../static/handles/masks.js';
import { due } from '../../static/store/edits.js';
import { server, ui } from '../../static/store/state.js';

const view = { name: 'main', fromView: (p) => p };
let now = 0;

function twice(target) {
  now += 10_000;
  for (const time of [now, now + 100]) click(view, { x: 50, y: 50, time }, target, []);
}

beforeEach(() => {
  due(1);
  Object.assign(server, {
    view: { frame: 0, selected: null },
    body: { parts: [], handles: [{ limb: ['upper_arm', 'forearm'] }] },
    masks: [
      {
        first: 0,
        last: 9,
        polygon: [
          [0, 0],
          [9, 0],
          [9, 9],
          [0, 9],
        ],
      },
    ],
  });
  Object.assign(ui, { limb: null, mask: 0, tool: 'select' });
});

test('twice on a shoulder, as on any handle, selects its limb', () => {
  twice({ key: 'grip:left_shoulder', kind: 'corner', handle: { kind: 'joint' }, part: 'upper_arm', at: [50, 50] });
  assert.deepEqual(ui.limb, ['upper_arm', 'forearm']);
});

test('a second click, later than a double click, selects the part behind, and after the last the first', () => {
  const selected = [];
  for (const again of [0, 1000, 2000]) {
    now = 100_000 + again;
    click(view, { x: 70, y: 70, time: now }, null, ['hand', 'chest']);
    selected.push(...due(1).map(({ part }) => part));
    server.view.selected = selected.at(-1);
  }
  assert.deepEqual(selected, ['hand', 'chest', 'hand']);
});

test('twice on a corner of a mask takes it away, and on what a mask has else nothing', () => {
  const [corner, edge, ...rest] = masksIn(view);
  for (const target of [edge, rest.at(-1)]) twice(target);
  assert.deepEqual(due(1), []);
  twice(corner);
  assert.deepEqual(
    due(1).map(({ do: what, polygon }) => [what, polygon]),
    [
      [
        'change_mask',
        [
          [9, 0],
          [9, 9],
          [0, 9],
        ],
      ],
    ],
  );
  assert.equal(ui.limb, null);
});
