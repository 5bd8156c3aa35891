// The body as the page paints it: what is seen of a part, what covers what, the light.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { farthestFirst, lit, outlined, paintPart, towardWhite } from '../../static/views/painting.js';

const project = ([x, y, z]) => [500 + (500 * x) / z, 500 + (500 * y) / z, z];
const at = (x, y, z) => [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z];

/** A box about the middle of its frame. */
function box(wide, high, deep) {
  const points = [-1, 1].flatMap((x) =>
    [-1, 1].flatMap((y) => [-1, 1].map((z) => [(x * wide) / 2, (y * high) / 2, (z * deep) / 2])),
  );
  const flats = [0, 1, 2].flatMap((k) =>
    [-1, 1].map((way) => ({
      points: points.filter((p) => Math.sign(p[k]) === way),
      normal: [0, 1, 2].map((i) => (i === k ? way : 0)),
    })),
  );
  const wires = [-1, 1].map((way) => ({
    ends: [
      [0, -high / 2, (way * deep) / 2],
      [0, high / 2, (way * deep) / 2],
    ],
    normal: [0, 0, way],
  }));
  return { points, flats, wires };
}

const seen = (solids, T, isParallel = false) => outlined(solids, T, project, isParallel);
const names = (parts) => farthestFirst(parts).map(({ name }) => name);

test('of a solid the sides and lines that face the eye are seen, by rays from the camera or parallel ones', () => {
  const solids = { cube: box(1, 1, 1) };
  const [straight] = seen(solids, { cube: at(0, 0, 5) });
  assert.equal(straight.flats.length, 1);
  assert.equal(straight.hidden.length, 5);
  assert.equal(straight.wires.length, 1);
  assert.equal(straight.hull.length, 4);
  const aside = { cube: at(3, 0, 5) };
  assert.equal(seen(solids, aside)[0].flats.length, 2);
  assert.equal(seen(solids, aside, true)[0].flats.length, 1);
});

test('parts behind the eye, and those whose place is not known, are left out', () => {
  const solids = { ahead: box(1, 1, 1), behind: box(1, 1, 1), nowhere: box(1, 1, 1) };
  assert.deepEqual(
    seen(solids, { ahead: at(0, 0, 5), behind: at(0, 0, -5) }).map(({ name }) => name),
    ['ahead'],
  );
});

test('near parts come after those that they cover, also where a long one has its middle farther away', () => {
  const solids = { near: box(1, 1, 0.2), far: box(1, 1, 0.2) };
  assert.deepEqual(names(seen(solids, { near: at(0, 0, 3), far: at(0, 0, 6) })), ['far', 'near']);
  // A rod that points almost at the eye: its middle is behind the plate, what is seen of it there is not.
  const rod = { rod: box(0.1, 8, 0.1), plate: box(1, 1, 0.05) };
  const towards = [1, 0, 0, 0.3, 0, 0.1, -0.995, 0.4, 0, 0.995, 0.1, 6.1];
  assert.deepEqual(names(seen(rod, { rod: towards, plate: at(0.3, -0.1, 5) })), ['plate', 'rod']);
});

test('every part is painted once, though they may cover each other in a ring', () => {
  const solids = Object.fromEntries(['a', 'b', 'c'].map((name) => [name, box(0.2, 4, 0.2)]));
  const turned = (deg, z) => {
    const [c, s] = [Math.cos((deg * Math.PI) / 180), Math.sin((deg * Math.PI) / 180)];
    return [c, -s * 0.98, 0, 0, s, c * 0.98, -0.2, 0, 0, 0.2, 0.98, z];
  };
  const T = { a: turned(0, 5), b: turned(60, 5), c: turned(120, 5) };
  assert.deepEqual(names(seen(solids, T)).sort(), ['a', 'b', 'c']);
});

test('what faces the light is brighter, and white stays as bright as it can be', () => {
  const [bright, dark] = [lit([111, 180, 255], [-0.45, -0.63, -0.63]), lit([111, 180, 255], [0.45, 0.63, 0.63])];
  bright.forEach((value, k) => assert.ok(value > dark[k] && value <= 255 && dark[k] >= 0));
  assert.deepEqual(towardWhite([0, 100, 255], 0.5), [128, 178, 255]);
});

/** A canvas that notes how each area was filled. */
class Canvas {
  fills = [];
  globalCompositeOperation = 'source-over';
  fill() {
    this.fills.push(this.globalCompositeOperation);
  }
  createLinearGradient = () => ({ addColorStop() {} });
  beginPath() {}
  closePath() {}
  moveTo() {}
  lineTo() {}
  stroke() {}
}

test('a part takes away what lies behind it, whether or not it has a colour itself', () => {
  const [part] = seen({ cube: box(1, 1, 1) }, { cube: at(0, 0, 5) });
  const fillsAt = (opacity) => {
    const canvas = new Canvas();
    paintPart(/** @type {any} */ (canvas), part, {
      colour: [1, 2, 3],
      opacity,
      isWired: true,
      line: [1, 1, 1],
      width: 1,
    });
    return canvas.fills;
  };
  assert.deepEqual(fillsAt(0), ['destination-out', 'destination-out']);
  assert.deepEqual(fillsAt(0.5), ['destination-out', 'source-over', 'destination-out', 'source-over']);
});
