// The lanes: how much the image shows of each part over the frames. Height says how much; hatched
// where it shows too little.

import { clamp } from '../../controls/arithmetic.js';
import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { onEnter } from '../../controls/focus.js';
import { frame, settle } from '../../actions/playhead.js';
import { select } from '../../store/parts.js';
import { server, setUi, ui } from '../../store/state.js';
import { GUTTER, right } from '../draw/scale.js';
import { extent, memoize, numbers, runsOf } from '../draw/series.js';
import { frames, scrub } from './frames.js';

/** @type {import('../mark.js').Mark} */
export const lane = {
  kind: 'lane',
  layers: [
    { group: 'frames', z: 40, from: () => [server.view?.selected], draw: drawLanes },
    { group: 'above', z: 40, from: () => [server.view?.selected], draw: drawLabels },
  ],
  hit({ y }, { rows, lanes, scroll }) {
    const within = y - rows.lanes.y;
    const there = within >= 0 && within < rows.lanes.room && lanes[Math.floor((within + scroll) / rows.lanes.each)];
    return there && { lane: there };
  },
  grab: (_, place) => scrub(place),
  click(what) {
    settle();
    selectOf(what.lane);
  },
  menu: frames.menu,
};

const HIDDEN_BELOW = 0.35;

/** Half the mean of several parts, half the worst: a limb whose hand is hidden is not seen well. */
const meanAndWorst = (sum, count, worst) => (sum / count + worst) / 2;
const worstOf = (sum, count, worst) => worst;

/** One value a frame of several parts' series, by `how(sum, count, worst)`; NaN where no part has a value. */
function combine(series, how) {
  const result = new Float32Array(Math.max(0, ...series.map((values) => values.length)));
  for (let i = 0; i < result.length; i += 1) {
    let sum = 0;
    let count = 0;
    let worst = Infinity;
    for (const values of series) {
      const value = values[i];
      // Missing values are NaN, which equals nothing, itself included.
      if (value !== value) continue;
      sum += value;
      count += 1;
      if (value < worst) worst = value;
    }
    result[i] = count === 0 ? NaN : how(sum, count, worst);
  }
  return result;
}

const of = (lanes, parts) => parts.filter((part) => lanes[part]).map((part) => numbers(lanes[part]));

/** Whether any part has a value anywhere. */
export const anyLane = memoize((lanes) =>
  Object.values(lanes ?? {}).some((values) => extent(numbers(values)) !== null),
);

/**
 * The lanes from top to bottom: {label, parts, values, kind: "group|part|weakest", open}.
 * `open` names the groups whose parts are listed under them.
 */
export const lanesOf = memoize((lanes, body, folded, open) => {
  if (!body || !anyLane(lanes)) return [];
  const parts = body.parts.map((part) => part.name);
  if (folded) {
    const values = combine(of(lanes, parts), worstOf);
    return [{ label: 'Weakest part', parts, values, kind: 'weakest' }];
  }
  const labels = new Map(body.parts.map((part) => [part.name, part.label]));
  return body.lanes.flatMap((group) => {
    const isOpen = open.has(group.label);
    const values = combine(of(lanes, group.parts), meanAndWorst);
    const head = { ...group, values, kind: 'group', open: isOpen };
    if (!isOpen) return [head];
    const single = (part) => ({
      label: labels.get(part) ?? part,
      parts: [part],
      values: lanes[part] ?? [],
      kind: 'part',
    });
    return [head, ...group.parts.map(single)];
  });
});

/** Select the part a lane means: the selected one if it is there, else the weakest here. */
function selectOf(one) {
  const value = (part) => server.lanes?.[part]?.[frame()] ?? Infinity;
  const weakest = () => one.parts.reduce((best, part) => (value(part) < value(best) ? part : best), one.parts[0]);
  const part = isSelected(one) ? server.view.selected : weakest();
  if (part) select(part);
}

function toggle({ label }) {
  const open = new Set(ui.timeOpen);
  if (!open.delete(label)) open.add(label);
  setUi('timeOpen', open);
}

const WORD_PX = 52;

/** Where lane `i` stands: {y, h, base}; `scroll` pixels of lanes are above the first one shown. */
function laneBox(rows, i, scroll) {
  const y = rows.lanes.y + i * rows.lanes.each - scroll;
  const h = rows.lanes.each - 3;
  return { y, h, base: y + h };
}

const isSelected = ({ kind, parts }) => kind !== 'weakest' && parts.includes(server.view?.selected);

function drawLanes({ rows, lanes, scroll }) {
  // Scrolled lanes end where their room ends.
  return svg`<clipPath id="tl-lanes"><rect x="0" y=${rows.lanes.y - 1} width="100000" height=${rows.lanes.room + 1}
    /></clipPath>
    <g clip-path="url(#tl-lanes)">${lanes.map((one, i) => drawLane(one, laneBox(rows, i, scroll)))}</g>`;
}

function drawLane(one, { y, h, base }) {
  const runs = runsOf(one.values);
  const area = runs.map((run) => areaOf(run, base, h)).join('');
  const hatched = runs.flatMap(hiddenRuns);
  const kind = `lane ${one.kind}${isSelected(one) ? ' selected' : ''}`;
  return svg`<path class=${kind} d=${area} />
    ${hatched.map(
      ([from, to]) => svg`<rect x=${from} y=${y} width=${to - from} height=${h}
      fill="url(#tl-hidden)" />${drawHidden(from, to, base)}`,
    )}`;
}

function drawHidden(from, to, base) {
  if (to - from < WORD_PX) return nothing;
  const at = (Math.max(from, GUTTER) + Math.min(to, right())) / 2;
  return svg`<text class="hidden" x=${at} y=${base - 1} text-anchor="middle">hidden</text>`;
}

function areaOf(run, base, h) {
  // The first and the last column reach to their outer edges, so that one frame alone is seen.
  const from = run[0].x - 1;
  const to = run.at(-1).x + 1;
  const top = (value) => (base - clamp(value, 0, 1) * h).toFixed(1);
  const point = (at, value) => `L${at.toFixed(1)} ${top(value)}`;
  const points = run.map((column) => point(column.x, column.low)).join('');
  const ends = [point(from, run[0].low), point(to, run.at(-1).low)];
  return `M${from.toFixed(1)} ${base}${ends[0]}${points}${ends[1]}V${base}Z`;
}

/** Stretches below the limit as [from, to] in pixels, a little wider than they are. */
function hiddenRuns(run) {
  const stretches = [];
  let open = null;
  for (const column of run) {
    if (column.low >= HIDDEN_BELOW) {
      open = null;
    } else if (open === null) {
      stretches.push((open = [column.x - 4, column.x + 4]));
    } else {
      open[1] = column.x + 4;
    }
  }
  return stretches;
}

/** Names of the lanes; a group's arrow opens its parts. */
function drawLabels({ rows, lanes, scroll }) {
  const label = (one, i) => {
    const { h, base, y } = laneBox(rows, i, scroll);
    const indent = { weakest: 12, group: 26, part: 38 }[one.kind];
    const ink = `lanename${isSelected(one) ? ' lbl' : ''}${one.kind === 'part' ? ' single' : ''}`;
    const name = svg`<text class=${ink} x=${indent} y=${base - Math.max(0, (h - 11) / 2)}
      @click=${() => selectOf(one)}>${one.label}</text>`;
    return one.kind === 'group' ? [arrow(one, y, h), name] : name;
  };
  return svg`<g clip-path="url(#tl-lanes)">${lanes.map(label)}</g>${drawThumb(rows, scroll)}`;
}

function arrow(one, y, h) {
  const middle = y + h / 2 + 1.2;
  const shape = one.open ? `M12.5 ${middle - 1.5}l3 3 3-3` : `M14 ${middle - 3}l3 3-3 3`;
  return svg`<g class="arrow" role="button" tabindex="0" aria-expanded=${String(one.open)}
      aria-label=${`Parts of ${one.label}`} @click=${() => toggle(one)} @keydown=${onEnter(() => toggle(one))}>
    <rect x="4" y=${y - 1} width="20" height=${h + 3} rx="3" /><path d=${shape} /></g>`;
}

/** How far the lanes are scrolled, where they do not all fit. */
function drawThumb(rows, scroll) {
  const { full, room, y } = rows.lanes;
  if (full <= room + 0.5) return nothing;
  return svg`<rect class="thumb" x=${GUTTER - 5} y=${y + (scroll / full) * room} width="3" rx="1.5"
    height=${(room / full) * room} />`;
}
