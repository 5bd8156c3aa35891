// The row of pins: a bar for every range a part stands still in, right limbs above left ones; what is
// proposed is dashed. Folded away it is one thin line.

import { html, nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { menuItem } from '../../actions/buttons.js';
import { acceptMessage, allPins, framesOf, proposedPins, showPin, unpin } from '../../actions/pins.js';
import { draftFrames, keyFrames, stopPlaying } from '../../actions/playhead.js';
import { clamp } from '../../controls/arithmetic.js';
import { keepsKey } from '../../controls/focus.js';
import { Stroke } from '../../controls/gesture.js';
import { ANCHOR, icon } from '../../controls/icons.js';
import { content, heading, line, openMenuAt } from '../../controls/menu.js';
import { clampFrame, lastFrame } from '../../store/clip.js';
import { send } from '../../store/link.js';
import { partNamed } from '../../store/parts.js';
import { server, setUi, ui } from '../../store/state.js';
import { frameAt, GUTTER, isIn, pxPerFrame, seenOf, snapped, x } from '../draw/scale.js';
import { memoize } from '../draw/series.js';
import { plate } from '../draw/glyphs.js';
import { held, hovered } from '../pointer.js';

/** @type {import('../mark.js').Mark} */
export const pin = {
  kind: 'pin',
  layers: [
    {
      group: 'frames',
      z: 50,
      from: () => [server.pins, server.proposed_pins, server.body, ui.timePin, held('pin')],
      draw: ({ rows }) => drawPins(rows.pins),
    },
    {
      group: 'above',
      z: 50,
      from: () => [server.pins, server.proposed_pins, server.body],
      draw: ({ rows }) => drawPinLabels(rows.pins),
    },
  ],
  hit(place, { rows }) {
    const bar = barAt(rows.pins, place);
    return bar?.index !== undefined && { index: bar.index, end: endAt(bar, place.x) };
  },
  cursor: ({ end }) => (end === 'middle' ? 'grab' : 'ew-resize'),
  edits: true,
  grab,
  click({ index }, { x: px }) {
    setUi('timePin', index);
    show(allPins()[index], px);
  },
  menu({ index }, { page }) {
    const { [index]: one } = allPins();
    const { keyframe } = one;
    openMenuAt(
      `${one.label} ${framesOf(one)}`,
      [
        heading(`${one.label} · pinned ${framesOf(one)}`),
        one.problem ? content(html`<div class="says check">${icon('warn')}<span>${one.problem}</span></div>`) : null,
        ...(keyframe === null
          ? []
          : [
              menuItem('softKey', keyframe),
              menuItem('splitPin', { index, frame: keyframe }),
              menuItem('goTo', keyframe),
            ]),
        menuItem('unpin', index, { right: framesOf(one) }),
      ],
      page,
    );
  },
  tip: ({ index }, rows) => drawTip(allPins()[index], rows),
  /** "Left foot 0–66 was 71". */
  drag({ index, end, from }, rows) {
    const one = allPins()[index];
    if (!one || !rows.pins || rows.pins.thin) return nothing;
    const isSame = one.first === from.first && one.last === from.last;
    const was = end === 'middle' ? framesOf(from) : from[end];
    const at = end === 'middle' ? middleOf(one) : x(one[end]) + (end === 'last' ? 60 : -60);
    return plate(`${one.label} ${framesOf(one)}`, at, below(rows.pins, one), isSame ? '' : ` was ${was}`);
  },
};

/** A pin that waits to be accepted: a click goes there. @type {import('../mark.js').Mark} */
export const proposal = {
  kind: 'proposal',
  hit(place, { rows }) {
    const bar = barAt(rows.pins, place);
    return bar?.index === undefined && bar && away(bar, place.x) === 0 && { part: bar.pin.part, first: bar.pin.first };
  },
  cursor: 'pointer',
  grab() {
    stopPlaying();
    return { move: () => null };
  },
  click: (what, { x: px }) => show(proposalOf(what), px),
  open(what) {
    const one = proposalOf(what);
    if (one) send(acceptMessage(one));
  },
  menu(what, { page }) {
    const one = proposalOf(what);
    openMenuAt(
      `${one.label} ${framesOf(one)}`,
      [
        heading(`${one.label} · proposed ${framesOf(one)}`),
        menuItem('acceptPins', one),
        menuItem('dismissPins', one),
        line,
        menuItem('acceptPins'),
      ],
      page,
    );
  },
  tip: (what, rows) => drawTip(proposalOf(what), rows, ' proposed · double-click to accept'),
};

const proposalOf = ({ part, first }) => proposedPins().find((one) => one.part === part && one.first === first);
const middleOf = ({ first, last }) => (x(first) + x(last)) / 2;

/** Go to the frame of a pin at a pixel. */
function show(one, px) {
  if (one) showPin(one, clamp(clampFrame(frameAt(px)), one.first, one.last));
}

function drawTip(one, rows, more = '') {
  if (!one || !rows.pins) return nothing;
  const words = (!more && one.problem) || `${one.label} ${framesOf(one)}${more}`;
  return plate(words, middleOf(one), below(rows.pins, one));
}

/**
 * Grab a pin at one of its ends, or whole; the drag is one step of undo. Unless Alt is down an end snaps to
 * keyframes, and to where the part begins or ends to stand.
 */
function grab({ index, end }, start) {
  const { first, last } = allPins()[index];
  const offset = end === 'middle' ? 0 : x(end === 'first' ? first : last) - start.x;
  const edges = [...keyFrames(), ...draftFrames(), ...(server.still?.[index] ?? [])];
  const stroke = new Stroke('pin', (span) => ({ do: 'change_pin', index, ...span }));
  stopPlaying();
  return {
    move(place) {
      const by = clamp(Math.round(frameAt(place.x) - frameAt(start.x)), -first, lastFrame() - last);
      if (end === 'middle') stroke.move({ first: first + by, last: last + by });
      else stroke.move({ [end]: clampFrame(snapped(place.x + offset, place.alt ? [] : edges)) });
      return { index, end, from: { first, last } };
    },
    end: () => stroke.end(),
    cancel: () => stroke.cancel(),
  };
}

const BAR = { h: 10, apart: 3, top: 4 };
const GRIP_REACH_PX = 6;
const GRIPS_FROM_PX = 16;
const LEAST_PX = 3;

/**
 * Where bars lie, one line for every part that has pins: those of the right side share the upper
 * bar's height, those of the left side the lower one's.
 */
const linesOf = memoize((pins, proposed) => {
  const sides = { upper: new Set(), lower: new Set() };
  const name = ({ part, landmarks }) => `${part} ${landmarks.length === 1 ? landmarks[0] : ''}`;
  for (const one of [...pins, ...proposed]) sides[one.side === 'L' ? 'lower' : 'upper'].add(name(one));
  return (one) => {
    const side = one.side === 'L' ? 'lower' : 'upper';
    const each = BAR.h / sides[side].size;
    const top = BAR.top + (side === 'lower' ? BAR.h + BAR.apart : 0);
    return {
      y: top + each * [...sides[side]].indexOf(name(one)),
      h: Math.max(2, each - (sides[side].size > 1 ? 1 : 0)),
    };
  };
});

const placeOf = (one) => linesOf(allPins(), proposedPins())(one);

/** The bars as they stand: {pin, index, from, to, y, h}; those proposed have no index. */
function bars(row) {
  const bar = (one, index = undefined) => {
    const { first, last } = one;
    const half = Math.max(0, (LEAST_PX - (last - first) * pxPerFrame()) / 2);
    const { y, h } = row.thin ? { y: 0, h: row.h } : placeOf(one);
    return { pin: one, index, first, last, from: x(first) - half, to: x(last) + half, y: row.y + y, h };
  };
  return seenOf([...proposedPins().map((one) => bar(one)), ...allPins().map(bar)]);
}

function drawPins(row) {
  if (!row) return nothing;
  return svg`<g class=${row.thin ? 'pins thin' : 'pins'}>
    ${drawCutOff(row)}${bars(row).map((bar) => (bar.index === undefined ? drawProposed(bar) : drawBar(bar, row)))}</g>`;
}

function drawProposed({ pin: { side }, from, to, y, h }) {
  return svg`<rect class=${`pin proposed ${side}`} x=${from + 0.75} y=${y + 0.75} rx="3"
    width=${Math.max(1, to - from - 1.5)} height=${Math.max(1, h - 1.5)} />`;
}

function drawBar({ pin: one, index, from, to, y, h }, row) {
  const wide = to - from;
  const isChosen = index === ui.timePin;
  const classes = `pin ${one.problem ? 'wrong' : one.side}${isChosen ? ' chosen' : ''}`;
  const grips = row.thin || wide < GRIPS_FROM_PX || h < 8 ? nothing : drawGrips(from, to, y, index);
  return svg`<rect class=${classes} x=${from} y=${y} width=${wide} height=${h} rx=${Math.min(3, h / 2)}>
    <title>${one.problem}</title></rect>${grips}`;
}

/** Two notches; the end that is pulled is a white grip. */
function drawGrips(from, to, y, index) {
  const pulled = held('pin')?.index === index ? held('pin').end : null;
  const grip = (at, end, inward) =>
    pulled === end
      ? svg`<rect class="grip" x=${at - 3} y=${y - 2} width="6" height="14" rx="1.5" />`
      : svg`<path class="notch" d=${`M${at + inward * 4} ${y + 2.5}v5`} />`;
  return svg`${grip(from, 'first', 1)}${grip(to, 'last', -1)}`;
}

/** What is being cut off, until it is. */
function drawCutOff(row) {
  const what = held('pin');
  const one = what && !row.thin ? allPins()[what.index] : undefined;
  if (!one || what.end === 'middle') return nothing;
  const { y, h } = placeOf(one);
  const [from, to] = what.end === 'last' ? [one.last, what.from.last] : [what.from.first, one.first];
  if (to <= from) return nothing;
  return svg`<rect class=${`cut ${one.side}`} x=${x(from)} y=${row.y + y + 0.5} width=${x(to) - x(from)} height=${h - 1}
    />
    <path class=${`cutend ${one.side}`} d=${`M${x(what.end === 'last' ? to : from)} ${row.y + y}v${h}`} />`;
}

const SIGN_PX = 13;

function drawPinLabels(row) {
  if (!row || row.thin) return nothing;
  const words = (sides) => sideWords([...allPins(), ...proposedPins()].filter(({ side }) => sides.includes(side)));
  const label = (sides, y) => {
    const { text, side } = words(sides);
    return text ? svg`<text class=${`side ${side}`} x=${GUTTER - 10} y=${y} text-anchor="end">${text}</text>` : nothing;
  };
  return svg`<svg class="sign" x="9" y=${row.y + (row.h - SIGN_PX) / 2} width=${SIGN_PX} height=${SIGN_PX}
    viewBox="0 0 16 16">${ANCHOR}</svg>
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

const away = ({ from, to }, px) => Math.max(from - px, px - to, 0);

/** The bar at a place, the nearest of those that reach so far. */
function barAt(row, { x: px, y: py }) {
  if (!row || row.thin || !isIn(row, py)) return undefined;
  const near = bars(row).filter((bar) => away(bar, px) <= GRIP_REACH_PX && py >= bar.y - 2 && py <= bar.y + bar.h + 2);
  return near.reverse().sort((a, b) => away(a, px) - away(b, px))[0];
}

/** A short bar is all middle but for what lies outside of it. */
function endAt({ from, to }, px) {
  const inside = Math.min(GRIP_REACH_PX, (to - from) / 4);
  if (px <= from + inside) return 'first';
  return px >= to - inside ? 'last' : 'middle';
}

/** Where the words about a pin stand. */
function below(row, one) {
  const { y, h } = placeOf(one);
  return row.y + y + h + 15;
}

/** Keys and words for the status bar while the pointer is at a pin, or pulls it; else null. */
export function pinHints() {
  if (held('pin')) {
    return [
      ['Alt', 'free, no snapping'],
      ['Esc', 'cancel'],
    ];
  }
  return hovered()?.kind === 'pin'
    ? [
        ['Drag an end', 'trim the pin'],
        ['Drag', 'move it'],
        ['Click', 'go there'],
        ['Delete', 'unpin the one clicked'],
      ]
    : null;
}

/** The chosen pin's keys: Delete unpins it, Esc lets go of it. */
export function listenForPinKeys() {
  addEventListener('pointerdown', () => setUi('timePin', null), true);
  addEventListener(
    'keydown',
    (event) => {
      if (ui.timePin == null || !allPins()[ui.timePin] || keepsKey(event.key)) return;
      if (event.key === 'Delete' || event.key === 'Backspace') unpin(ui.timePin);
      else if (event.key !== 'Escape') return;
      setUi('timePin', null);
      event.preventDefault();
      event.stopImmediatePropagation();
    },
    true,
  );
}
