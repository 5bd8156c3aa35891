// The keyframes on the curve of the selected part, to be dragged up and down; with that curve.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { frame, goTo, isKey, stopPlaying } from '../../actions/playhead.js';
import { clamp, shortNumber, signedNumber } from '../../controls/arithmetic.js';
import { Stroke } from '../../controls/gesture.js';
import { frameCount } from '../../store/clip.js';
import { partNamed } from '../../store/parts.js';
import { server, ui } from '../../store/state.js';
import { axis, curveKeys, drawCurve, drawCurveLabels, freezeRange, hasCurve, scale, valueAt } from '../draw/curve.js';
import { GUTTER, hitNear, right, x } from '../draw/scale.js';
import { diamond, LETTER_PX, plate } from '../draw/glyphs.js';
import { held } from '../pointer.js';
import { openKeyMenu, withRoom } from './keyframes.js';
import { isScore } from './scores.js';

const REACH_PX = 9;
const RADIUS = 4.5;
const FINE = 0.1;
const STEP_DEG = 5;

const layer = (group, z, draw, more = () => []) => ({
  group,
  z,
  from: () => [
    isScore(),
    server.curve,
    server.segments,
    server.keys,
    server.body,
    ui.curveAxis,
    held('curvekey')?.frame,
    ...more(),
  ],
  draw: ({ rows }) => (isScore() ? nothing : draw(rows.curve)),
});

/** @type {import('../mark.js').Mark} */
export const curveKey = {
  kind: 'curvekey',
  layers: [
    layer('frames', 100, drawCurve),
    layer('frames', 101, drawKeys),
    layer('frames', 170, drawCurrent, () => [frame()]),
    layer('above', 100, drawCurveLabels),
  ],
  hit({ x: px, y: py }, { rows }) {
    const at = rows.curve !== null && py >= rows.curve.y ? scale(rows.curve) : null;
    if (at === null || px < GUTTER) return null;
    return hitNear(
      withRoom(curveKeys()).filter((key) => Math.abs(at.y(valueAt(key)) - py) <= REACH_PX),
      px,
      REACH_PX,
    );
  },
  cursor: 'ns-resize',
  edits: true,
  grab: ({ frame: at }, start, { rows }) => grab(at, start, rows.curve),
  click: ({ frame: at }) => goTo(at),
  menu: ({ frame: at }, { page }) => openKeyMenu(at, page),
  tip({ frame: key }, rows) {
    const value = valueAt(key);
    return value === null ? nothing : drawLarge('hover', key, value, 7, `${shortNumber(value, 1)}°`, rows.curve);
  },
  drag({ frame: key, part, about, from, deg }, rows) {
    const word = partNamed(part)?.words?.[about] ?? about.toUpperCase();
    return drawLarge(
      'curvekey current',
      key,
      deg,
      6,
      `${word} ${shortNumber(deg, 1)}°  ${signedNumber(deg - from, 1)}`,
      rows.curve,
    );
  },
};

/** The whole drag is one stroke, so one step of undo. @returns {import('../mark.js').Gesture} */
function grab(at, start, row) {
  const part = server.curve.part;
  const about = axis();
  const from = valueAt(at);
  const degPerPx = scale(row).value(0) - scale(row).value(1);
  const stroke = new Stroke('angle', (value) => ({ do: 'key_angle', frame: at, part, axis: about, deg: value }));
  let y = start.y;
  let deg = from;
  let begun = false;
  const begin = () => {
    begun = true;
    freezeRange(true);
    goTo(at);
  };
  stopPlaying();
  return {
    move(place) {
      if (!begun) begin();
      // Step by step, so that Shift may be pressed midway without a jump.
      deg += (y - place.y) * degPerPx * (place.shift ? FINE : 1);
      y = place.y;
      const value = place.ctrl ? Math.round(deg / STEP_DEG) * STEP_DEG : Math.round(deg * 10) / 10;
      stroke.move(value);
      return { frame: at, about, part, from, deg: value };
    },
    end() {
      stroke.end();
      freezeRange(false);
    },
    cancel() {
      stroke.cancel();
      freezeRange(false);
    },
  };
}

const isShown = (row) => row !== null && hasCurve() && frameCount() > 0 && scale(row) !== null;
const mark = (key, { y }) => diamond(x(key).toFixed(1), y(valueAt(key)), RADIUS);

/** Where keys stand too close for diamonds, the keyframe row shows them well enough. */
function drawKeys(row) {
  if (!isShown(row)) return nothing;
  const shown = withRoom(curveKeys()).filter((key) => key !== held('curvekey')?.frame);
  const at = scale(row);
  return svg`<path class="curvekey" d=${shown.map((key) => mark(key, at)).join('')} />`;
}

/** The current key's diamond on the curve, in the accent. */
function drawCurrent(row) {
  if (held('curvekey') || !isShown(row) || !isKey(frame()) || valueAt(frame()) === null) return nothing;
  return svg`<path class="curvekey current" d=${mark(frame(), scale(row))} />`;
}

/** One at its value, with words beside it on the side where there is room. */
function drawLarge(looks, key, value, radius, words, row) {
  if (row === null || scale(row) === null) return nothing;
  const [at, y] = [x(key), clamp(scale(row).y(value), row.y, row.y + row.h)];
  const half = (words.length * LETTER_PX) / 2 + 7;
  const side = at + 2 * half + 24 > right() ? -1 : 1;
  return svg`<path class=${looks} d=${diamond(at, y, radius)} />
    ${plate(words, at + side * (half + 12), clamp(y, row.y + 8, row.y + row.h - 10))}`;
}
