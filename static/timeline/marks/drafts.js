// Drafts on the timeline: stretches of them as one dashed bar, single ones as hollow diamonds, and over
// them the numbered places that a person should confirm.

import { svg } from '../../vendor/lit-html/lit-html.js';
import { server } from '../../store/state.js';
import { reasonOf } from '../../actions/drafting.js';
import { draftFrames, placesToConfirm, settle } from '../../actions/playhead.js';
import { BAR, GUTTER, hitNear, right, seenOf, visible, x } from '../draw/scale.js';
import { named } from '../draw/glyphs.js';
import { scrub } from './frames.js';

const RING = 8;
const REACH_PX = 10;
const WORD_PX = 44;
/** Fewer drafts in a row are posed by hand. */
const FEWEST = 3;

/** A place to confirm. @type {import('../mark.js').Mark} */
export const draft = {
  kind: 'place',
  row: 'keys',
  layers: [
    {
      group: 'frames',
      z: 90,
      from: () => [server.keys, server.segments, server.draft],
      draw: ({ rows }) => drawStretches(rows.keys),
    },
    {
      group: 'frames',
      z: 150,
      from: () => [server.draft],
      draw: ({ rows, bottom }) => seenOf(placesToConfirm()).map((place) => drawPlace(place, rows.keys.middle, bottom)),
    },
  ],
  hit: ({ x: px }) =>
    hitNear(
      placesToConfirm().map(({ frame }) => frame),
      px,
      REACH_PX,
    ),
  cursor: 'pointer',
  grab: ({ frame }, start) => scrub({ ...start, x: x(frame) }),
  click: settle,
  tip({ frame: at }, rows) {
    const place = placesToConfirm().find(({ frame }) => frame === at);
    return place && named(`${reasonOf(place)}. Go to ${at}`, x(at), rows);
  },
};

/**
 * Drafts outside all segments: stretches [first, last] without a gap, and those that stand alone.
 * Between keyframes it is the segment that is shown.
 * @param {number[]} frames  Ascending.
 * @param {{ first: number, last: number }[]} segments
 */
export function draftStretches(frames, segments) {
  /** @type {[number, number][]} */
  const runs = [];
  for (const at of frames) {
    const run = runs.at(-1);
    if (run && at === run[1] + 1) run[1] = at;
    else runs.push([at, at]);
  }
  const isLong = ([first, last]) => last - first + 1 >= FEWEST;
  const long = runs.filter(isLong);
  const alone = runs
    .filter((run) => !isLong(run))
    .flatMap(([first, last]) => (first === last ? [first] : [first, last]));
  const stretches = long.filter(([first, last]) => !segments.some((s) => s.first < first && last < s.last));
  return { stretches, alone };
}

/** The drafts that stand alone. */
export const singleDrafts = () => draftStretches(draftFrames(), server.segments ?? []).alone;

function drawStretches({ middle }) {
  const { first, last } = visible();
  const { stretches } = draftStretches(draftFrames(), server.segments ?? []);
  return stretches.filter(([from, to]) => to >= first && from <= last).map((run) => drawStretch(run, middle));
}

function drawStretch([first, last], middle) {
  const [from, to] = [x(first), x(last)];
  const [seenFrom, seenTo] = [Math.max(from, GUTTER), Math.min(to, right())];
  const at = wordPlace(seenFrom, seenTo);
  const bar = (name) => svg`<rect class=${name} x=${from} y=${middle - BAR.half + 0.5} width=${Math.max(1, to - from)}
    height=${2 * BAR.half - 1} rx="3" />`;
  return svg`${bar('f-panel')}${bar('drafted')}
    ${
      at === null
        ? null
        : svg`<rect class="f-panel" x=${at - WORD_PX / 2} y=${middle - 8} width=${WORD_PX} height="16" rx="8" />
      <text class="word f-track" x=${at} y=${middle + 4} text-anchor="middle">Draft</text>`
    }`;
}

/** Where the word hides no ring; null where no place is free. */
function wordPlace(from, to) {
  const rings = placesToConfirm().map((place) => x(place.frame));
  const free = (at) => rings.every((ring) => Math.abs(ring - at) > WORD_PX / 2 + RING + 2);
  const fits = (at) => at - WORD_PX / 2 > from && at + WORD_PX / 2 < to;
  return [0.08, 0.2, 0.5, 0.8].map((share) => from + (to - from) * share).find((at) => fits(at) && free(at)) ?? null;
}

/** A numbered ring, and a dashed line down. */
function drawPlace(place, middle, bottom) {
  const at = x(place.frame);
  return svg`<g class="place"><path class="down" d=${`M${at} ${middle + RING}V${bottom}`} />
    <circle cx=${at} cy=${middle} r=${RING} />
    <text x=${at} y=${middle + 3.8} text-anchor="middle">${placesToConfirm().indexOf(place) + 1}</text></g>`;
}
