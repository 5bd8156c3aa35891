// Error per pass of the segment the playhead is in: is it still falling, and which pass is kept.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { frame, segmentAt } from '../../actions/playhead.js';
import { range } from '../../controls/words.js';
import { isSurface } from '../../store/clip.js';
import { server, ui } from '../../store/state.js';
import { GUTTER, right } from '../draw/scale.js';
import { frames } from './frames.js';

const PITCH_MOST = 64;
const AXIS_H = 14;

const isChosen = () => ui.chart === 'score' && !isSurface();
export const isScore = () => isChosen() && (server.segments ?? []).length > 0;

/** Where frames end: the chart of scores under them has passes across, not frames. */
export const bottomOf = (rows) => (isScore() && rows.curve !== null ? rows.curve.y - 3 : rows.height);

const layer = (group, draw) => ({
  group,
  z: 100,
  from: () => [isScore() && segmentAt(frame())],
  draw: ({ rows }) => (isScore() ? draw(rows.curve) : nothing),
});

/** @type {import('../mark.js').Mark} */
export const scoreChart = {
  kind: 'score',
  layers: [layer('frames', drawScores), layer('above', drawScoreLabels)],
  hit: ({ y }, { rows }) => isChosen() && rows.curve !== null && y >= rows.curve.y && {},
  menu: frames.menu,
};

/** The chart in the place of the curve: passes from left to right, the best one marked. */
function drawScores(row) {
  if (row === null) return nothing;
  const segment = segmentAt(frame());
  const known = scoresOf(segment);
  if (known.length === 0) return drawNothingYet(row);
  const place = placesOf(segment, row);
  const points = known.map(([score, i]) => `${place.x(i)} ${place.y(score)}`);
  return svg`<path class="s-line" d=${place.grid} />
    ${place.numbers.map(
      ([words, y]) => svg`<text class="d" x=${GUTTER + 34} y=${y + 4}
      text-anchor="end">${words}</text>`,
    )}
    ${place.ticks.map(
      (i) => svg`<text class="d" x=${place.x(i)} y=${row.y + row.h}
      text-anchor="middle">${i + 1}</text>`,
    )}
    <path class="score ahead" d=${place.ahead} />
    <path class=${`score ${segment.state}`} d=${`M${points.join('L')}`} />
    ${known.map(([score, i]) => drawPass(segment, score, i, place))}`;
}

/** The scores there are, with the number of their pass: [[score, pass], ...]. */
function scoresOf(segment) {
  return (segment?.scores ?? []).map((score, i) => [score, i]).filter(([score]) => score !== null);
}

function drawPass(segment, score, i, place) {
  const best = i === segment.best;
  return svg`<circle class=${`pass ${segment.state}${best ? ' best' : ''}`} cx=${place.x(i)}
      cy=${place.y(score)} r=${best ? 4.5 : 3}><title>Pass ${i + 1}: ${figures(score)}</title></circle>
    ${
      best
        ? svg`<text class="bestword" x=${place.x(i)} y=${place.wordY(score)}
      text-anchor="middle">best ${figures(score)}</text>`
        : nothing
    }`;
}

function drawNothingYet(row) {
  return svg`<text class="d" x=${(GUTTER + right()) / 2} y=${row.y + row.h / 2 + 4}
    text-anchor="middle">The error of each pass appears here once this segment is tracked.</text>`;
}

function placesOf(segment, row) {
  const scores = segment.scores;
  const count = Math.max(scores.length, segment.of ?? 0, 2);
  const from = GUTTER + 56;
  const pitch = Math.min(PITCH_MOST, (right() - from - 12) / (count - 1));
  const most = Math.max(...scoresOf(segment).map(([score]) => score)) || 1;
  const top = row.y + 10;
  const bottom = row.y + row.h - AXIS_H;
  const x = (i) => from + i * pitch;
  const y = (score) => bottom - (score / most) * (bottom - top);
  const every = Math.ceil(20 / pitch);
  const [last, done] = scoresOf(segment).at(-1);
  const more = segment.state === 'tracking' && count - 1 > done;
  const end = x(count - 1) + 12;
  return {
    x,
    y,
    // Above its point unless the chart ends there.
    wordY: (score) => (y(score) - 8 > row.y + 12 ? y(score) - 8 : y(score) + 16),
    grid: `M${from - 16} ${bottom + 0.5}H${end}M${from - 16} ${top + 0.5}H${end}`,
    numbers: [
      [figures(most), top],
      ['0', bottom],
    ],
    ticks: Array.from({ length: count }, (_, i) => i).filter((i) => i % every === 0),
    ahead: more ? `M${x(done)} ${y(last)}H${x(count - 1)}` : '',
  };
}

function figures(score) {
  return Number(score.toPrecision(3)).toString();
}

/** Left of the chart: which segment, and what is drawn. */
function drawScoreLabels(row) {
  if (row === null) return nothing;
  const segment = segmentAt(frame());
  const which = segment ? `Segment ${range(segment.first, segment.last)}` : 'No segment here';
  const second = row.h > 34 ? svg`<text x="12" y=${row.y + 29}>Error per pass</text>` : nothing;
  const third =
    row.h > 46 && scoresOf(segment).length > 0
      ? svg`<text class="d" x="12" y=${row.y + 44}>lower is better</text>`
      : nothing;
  return svg`<text class="lbl" x="12" y=${row.y + 14}>${which}</text>${second}${third}`;
}
