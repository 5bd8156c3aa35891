// Part keyframes on the timeline: diamonds half filled, in the colour of the limb that is exact there.

import { svg } from '../../vendor/lit-html/lit-html.js';
import { partKeyAt, partKeys } from '../../actions/limbs.js';
import { frame } from '../../actions/playhead.js';
import { GUTTER, right, visible, x } from './scale.js';

const RADIUS = 7.5;
const REACH = 11;

/**
 * How a part keyframe is filled: below the middle in its limb's colour, of two limbs left and right in
 * theirs, of more in that of the trunk. [side, path] for each colour, about a point.
 * @param {{ side: string }[]} limbs
 * @returns {['L' | 'R' | 'C', string][]}
 */
export function fillsOf(limbs, cx, cy, r) {
  const side = (limb) => /** @type {'L' | 'R' | 'C'} */ (limb.side);
  if (limbs.length === 2) {
    return [
      [side(limbs[0]), `M${cx} ${cy - r}l${-r} ${r} ${r} ${r}z`],
      [side(limbs[1]), `M${cx} ${cy - r}l${r} ${r}-${r} ${r}z`],
    ];
  }
  return [[limbs.length === 1 ? side(limbs[0]) : 'C', `M${cx - r} ${cy}h${2 * r}l${-r} ${r}z`]];
}

/** The outline in as many colours: whole, or a half for each of two limbs. */
function outlinesOf(fills, cx, cy, r) {
  if (fills.length === 1) return [[fills[0][0], `M${cx} ${cy - r}l${r} ${r}-${r} ${r}-${r}-${r}z`]];
  return [
    [fills[0][0], `M${cx} ${cy - r}l${-r} ${r} ${r} ${r}`],
    [fills[1][0], `M${cx} ${cy - r}l${r} ${r}-${r} ${r}`],
  ];
}

/** One mark about a point. */
function partMark(limbs, cx, cy, kind = '') {
  const fills = fillsOf(limbs, cx, cy, RADIUS);
  return svg`<g class=${`partkey ${kind}`}>
    <path class="ground" d=${`M${cx} ${cy - RADIUS}l${RADIUS} ${RADIUS}-${RADIUS} ${RADIUS}-${RADIUS}-${RADIUS}z`} />
    ${fills.map(([side, d]) => svg`<path class=${`fill ${side}`} d=${d} />`)}
    ${outlinesOf(fills, cx, cy, RADIUS).map(([side, d]) => svg`<path class=${`line ${side}`} d=${d} />`)}</g>`;
}

/** All of them, but for those that are on their way elsewhere. */
export function drawPartKeys(rows, without = []) {
  const { first, last } = visible();
  const seen = partKeys().filter((key) => key.frame >= first - 1 && key.frame <= last + 1);
  return seen.filter((key) => !without.includes(key.frame)).map((key) => partMark(key.limbs, x(key.frame), rows.keys.middle));
}

/** The one under the playhead, ringed in the accent. */
export function drawCurrentPart(rows) {
  const key = partKeyAt(frame());
  return key ? partMark(key.limbs, x(key.frame), rows.keys.middle, 'current') : null;
}

/** The frame of the part keyframe at a pixel, or null. */
export function partNear(px) {
  if (px < GUTTER || px > right() + RADIUS) return null;
  const apart = (key) => Math.abs(x(key.frame) - px);
  const near = partKeys().filter((key) => apart(key) <= REACH).sort((a, b) => apart(a) - apart(b));
  return near[0]?.frame ?? null;
}
