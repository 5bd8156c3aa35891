// The row of pins: a bar for every range a part stands still in, right limbs above left ones; what is
// proposed is dashed. Folded away it is one thin line.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { ANCHOR } from '../../controls/icons.js';
import { server, ui } from '../../store/state.js';
import { partNamed } from '../../store/parts.js';
import { allPins, proposedPins } from '../../actions/pins.js';
import { GUTTER, pxPerFrame, visible, x } from './scale.js';
import { memoize } from './series.js';
import { grabbed } from '../edit/pointer.js';

const BAR = { h: 10, apart: 3, top: 4 };
const GRIP_REACH_PX = 6;
const GRIPS_FROM_PX = 16;
const LEAST_PX = 3;

/** Whether there is anything to give a row to. */
export const hasPins = () => allPins().length + proposedPins().length > 0;

/**
 * Where bars lie, one line for every part that has pins: those of the right side share the upper
 * bar's height, those of the left side the lower one's.
 */
const linesOf = memoize((pins, proposed) => {
  const sides = { upper: new Set(), lower: new Set() };
  const name = ({ part, landmarks }) => `${part} ${landmarks.length === 1 ? landmarks[0] : ''}`;
  for (const pin of [...pins, ...proposed]) sides[pin.side === 'L' ? 'lower' : 'upper'].add(name(pin));
  const place = (pin) => {
    const side = pin.side === 'L' ? 'lower' : 'upper';
    const each = BAR.h / sides[side].size;
    const top = BAR.top + (side === 'lower' ? BAR.h + BAR.apart : 0);
    return { y: top + each * [...sides[side]].indexOf(name(pin)), h: Math.max(2, each - (sides[side].size > 1 ? 1 : 0)) };
  };
  return { place };
});

/** The bars as they stand: {pin, index, from, to, y, h}; those proposed have no index. */
function bars(row) {
  const { place } = linesOf(allPins(), proposedPins());
  const { first, last } = visible();
  const bar = (pin, index) => {
    const half = Math.max(0, (LEAST_PX - (pin.last - pin.first) * pxPerFrame()) / 2);
    const { y, h } = row.thin ? { y: 0, h: row.h } : place(pin);
    return { pin, index, from: x(pin.first) - half, to: x(pin.last) + half, y: row.y + y, h };
  };
  const all = [...proposedPins().map((pin) => bar(pin)), ...allPins().map(bar)];
  return all.filter(({ pin }) => pin.last >= first - 1 && pin.first <= last + 1);
}

export function drawPins(row) {
  if (!row) return nothing;
  return svg`<g class=${row.thin ? 'pins thin' : 'pins'}>
    ${drawCutOff(row)}${bars(row).map((bar) => (bar.index === undefined ? drawProposed(bar) : drawBar(bar, row)))}</g>`;
}

function drawProposed({ pin, from, to, y, h }) {
  return svg`<rect class=${`pin proposed ${pin.side}`} x=${from + 0.75} y=${y + 0.75} rx="3"
    width=${Math.max(1, to - from - 1.5)} height=${Math.max(1, h - 1.5)} />`;
}

function drawBar({ pin, index, from, to, y, h }, row) {
  const wide = to - from;
  const isChosen = index === ui.timePin;
  const classes = `pin ${pin.problem ? 'wrong' : pin.side}${isChosen ? ' chosen' : ''}`;
  const grips = row.thin || wide < GRIPS_FROM_PX || h < 8 ? nothing : drawGrips(from, to, y, index);
  return svg`<rect class=${classes} x=${from} y=${y} width=${wide} height=${h} rx=${Math.min(3, h / 2)}>
    <title>${pin.problem}</title></rect>${grips}`;
}

/** Two notches; the end that is pulled is a white grip. */
function drawGrips(from, to, y, index) {
  const pulled = grabbed()?.kind === 'pin' && grabbed().index === index ? grabbed().end : null;
  const grip = (at, end, inward) => pulled === end
    ? svg`<rect class="grip" x=${at - 3} y=${y - 2} width="6" height="14" rx="1.5" />`
    : svg`<path class="notch" d=${`M${at + inward * 4} ${y + 2.5}v5`} />`;
  return svg`${grip(from, 'first', 1)}${grip(to, 'last', -1)}`;
}

/** What is being cut off, until it is. */
function drawCutOff(row) {
  const held = grabbed();
  const pin = held?.kind === 'pin' && !row.thin ? allPins()[held.index] : undefined;
  if (!pin || held.end === 'middle') return nothing;
  const { y, h } = linesOf(allPins(), proposedPins()).place(pin);
  const [from, to] = held.end === 'last' ? [pin.last, held.from.last] : [held.from.first, pin.first];
  if (to <= from) return nothing;
  const end = x(held.end === 'last' ? to : from);
  return svg`<rect class=${`cut ${pin.side}`} x=${x(from)} y=${row.y + y + 0.5} width=${x(to) - x(from)} height=${h - 1} />
    <path class=${`cutend ${pin.side}`} d=${`M${end} ${row.y + y}v${h}`} />`;
}

const SIGN_PX = 13;

export function drawPinLabels(row) {
  if (!row || row.thin) return nothing;
  const words = (sides) => sideWords([...allPins(), ...proposedPins()].filter(({ side }) => sides.includes(side)));
  const label = (sides, y) => {
    const { text, side } = words(sides);
    return text ? svg`<text class=${`side ${side}`} x=${GUTTER - 10} y=${y} text-anchor="end">${text}</text>` : nothing;
  };
  return svg`<svg class="sign" x="9" y=${row.y + (row.h - SIGN_PX) / 2} width=${SIGN_PX} height=${SIGN_PX} viewBox="0 0 16 16">${ANCHOR}</svg>
    <text class="lbl" x="26" y=${row.y + row.h / 2 + 4}>Pins</text>
    ${label('RC', row.y + 12)}${label('L', row.y + 26)}`;
}

/** "R foot"; of several parts "Right". */
function sideWords(pins) {
  if (!pins.length) return { text: '', side: '' };
  const parts = [...new Set(pins.map(({ part }) => part))];
  const { side } = pins[0];
  const word = { L: 'Left', R: 'Right', C: 'Middle' }[side];
  if (parts.length > 1) return { text: word, side };
  const short = partNamed(parts[0])?.short ?? pins[0].label;
  return { text: side === 'C' ? short : `${side} ${short.toLowerCase()}`, side };
}

/** The bar at a place: {kind: "pin", index, end} or {kind: "proposal", pin}; null where there is none. */
export function pinAt(row, place) {
  if (!row || row.thin || place.y < row.y || place.y >= row.y + row.h) return null;
  const near = ({ from, to, y, h }) =>
    place.x >= from - GRIP_REACH_PX && place.x <= to + GRIP_REACH_PX && place.y >= y - 2 && place.y <= y + h + 2;
  const away = ({ from, to }) => Math.max(from - place.x, place.x - to, 0);
  const [bar] = bars(row).filter(near).reverse().sort((a, b) => away(a) - away(b));
  if (!bar) return null;
  if (bar.index === undefined) return away(bar) > 0 ? null : { kind: 'proposal', part: bar.pin.part, first: bar.pin.first };
  return { kind: 'pin', index: bar.index, end: endAt(bar, place.x) };
}

/** A short bar is all middle but for what lies outside of it. */
function endAt({ from, to }, px) {
  const inside = Math.min(GRIP_REACH_PX, (to - from) / 4);
  if (px <= from + inside) return 'first';
  return px >= to - inside ? 'last' : 'middle';
}

/** Where the words about a pin stand. */
export function belowPin(row, pin) {
  const { y, h } = linesOf(allPins(), proposedPins()).place(pin);
  return row.y + y + h + 15;
}

export const proposalOf = ({ part, first }) =>
  (server.proposed_pins ?? []).find((pin) => pin.part === part && pin.first === first);
