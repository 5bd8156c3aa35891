// The handle of a width stays under the pointer that pulls it.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { sizesIn } from '../../static/handles/sizes.js';
import { server, ui } from '../../static/store/state.js';

const PX_A_METRE = 400;
const view = { project: ([x, y, z]) => [PX_A_METRE * x, PX_A_METRE * y, z], pxPerMetre: () => PX_A_METRE };

/** Where the width's handle of a cylinder is, so many centimetres across. */
function rimOf(cm) {
  const part = { name: 'tin', label: 'Tin', sizes: [{ key: 'radius', label: 'Width', cm, at_cm: [cm / 2, 5, 0] }] };
  Object.assign(server, {
    body: { parts: [part] },
    view: { selected: 'tin' },
    pose: { T: { tin: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0] } },
  });
  ui.tool = 'size';
  const [{ at, foot }] = sizesIn(view);
  return Math.abs(at[0] - foot[0]);
}

test('the handle of a round width lies on the surface', () => {
  assert.equal(rimOf(10), 0.05 * PX_A_METRE);
});

test('a width that is pulled by as much on both sides takes its handle along with the pointer', () => {
  const pulledCm = 3;
  assert.equal(rimOf(10 + 2 * pulledCm) - rimOf(10), (pulledCm / 100) * PX_A_METRE);
});
