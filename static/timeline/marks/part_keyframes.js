// The keyframes of parts, half filled. They are grabbed and clicked as those of the whole body are.

import { svg } from '../../vendor/lit-html/lit-html.js';
import { perform } from '../../actions/actions.js';
import { menuItem } from '../../actions/buttons.js';
import { contextEntries } from '../../actions/context_menus.js';
import { partKeyAt, partKeys } from '../../actions/parts.js';
import { frame } from '../../actions/playhead.js';
import { heading, line, openMenuAt } from '../../controls/menu.js';
import { server } from '../../store/state.js';
import { GUTTER, hitNear, right, seenOf, x } from '../draw/scale.js';
import { diamond, named, plate } from '../draw/glyphs.js';
import { onTheWay } from '../pointer.js';
import { duplicate, keyframe, remove } from './keyframes.js';

const RADIUS = 7.5;
const REACH_PX = 11;

const isHere = ({ frame: at }) => !onTheWay().includes(at);

/** @type {import('../mark.js').Mark} */
export const partKeyframe = {
  ...keyframe,
  kind: 'part',
  layers: [
    {
      group: 'frames',
      z: 130,
      from: () => [server.keys, String(onTheWay())],
      draw: ({ rows }) =>
        seenOf(partKeys())
          .filter(isHere)
          .map((key) => drawKey(key, rows.keys)),
    },
    {
      group: 'frames',
      z: 170,
      from: () => [frame(), server.keys, String(onTheWay())],
      draw: ({ rows }) =>
        [partKeyAt()].filter((key) => key && isHere(key)).map((key) => drawKey(key, rows.keys, 'current')),
    },
  ],
  hit: ({ x: px }) =>
    px < GUTTER || px > right() + RADIUS
      ? null
      : hitNear(
          partKeys().map((key) => key.frame),
          px,
          REACH_PX,
        ),
  open: ({ frame: at }) => perform('keyWhole', at),
  menu: ({ frame: at }, { page }) => openPartKeyMenu(partKeyAt(at), page),
  tip({ frame: at }, rows) {
    const key = partKeyAt(at);
    return (
      key &&
      svg`<path class="hover" d=${diamond(x(at), rows.keys.middle, 10.5)}
        />${named(`Part keyframe ${at}`, x(at), rows, `  ${key.words}`)}
      ${plate(
        '',
        x(at),
        rows.keys.middle + 44,
        'The other parts follow tracking here. Double-click to key the whole pose.',
      )}`
    );
  },
};

export function openPartKeyMenu({ frame: at, limbs, words }, page) {
  const several = limbs.length > 1 ? limbs : [];
  openMenuAt(
    `Part keyframe ${at}`,
    [
      heading(`Part keyframe ${at} · ${words}`),
      menuItem('goTo', at),
      menuItem('keyWhole', at),
      ...several.map((limb) => menuItem('unkeyLimb', { frame: at, ...limb })),
      duplicate(at),
      ...contextEntries('partKeyframe', { note: at }),
      line,
      remove(at),
    ],
    page,
  );
}

/**
 * How a part keyframe is filled: below the middle in its limb's colour, of two limbs left and right in
 * theirs, of more in that of the trunk. [side, path] for each colour, about a point.
 * @param {{ side: string }[]} limbs
 * @returns {['L' | 'R' | 'C', string][]}
 */
export function fillsOf(limbs, cx, cy, r) {
  const side = (limb) => /** @type {'L' | 'R' | 'C'} */ (limb.side);
  if (limbs.length === 2) return halves(cx, cy, r).map((d, i) => [side(limbs[i]), `${d}z`]);
  return [[limbs.length === 1 ? side(limbs[0]) : 'C', `M${cx - r} ${cy}h${2 * r}l${-r} ${r}z`]];
}

const halves = (cx, cy, r) => [`M${cx} ${cy - r}l${-r} ${r} ${r} ${r}`, `M${cx} ${cy - r}l${r} ${r}-${r} ${r}`];

function drawKey({ frame: at, limbs }, { middle }, looks = '') {
  const whole = diamond(x(at), middle, RADIUS);
  const fills = fillsOf(limbs, x(at), middle, RADIUS);
  // The outline in as many colours: whole, or a half for each of two limbs.
  const outlines = fills.length === 1 ? [whole] : halves(x(at), middle, RADIUS);
  return svg`<g class=${`partkey ${looks}`}><path class="ground" d=${whole} />
    ${fills.map(([side, d]) => svg`<path class=${`fill ${side}`} d=${d} />`)}
    ${fills.map(([side], i) => svg`<path class=${`line ${side}`} d=${outlines[i]} />`)}</g>`;
}
