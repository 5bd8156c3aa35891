// The bodies that are not posed, a row each: its keyframes and segments, and below them, as a line, where a
// part of it holds one of the posed body or is held. A click poses it at that frame. Where parts of the posed
// body hold each other it has a row of such lines as well.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { perform } from '../../actions/actions.js';
import { bondsWith, otherEnd, ownEnd } from '../../actions/bonds.js';
import { leftToDo, posedWords } from '../../actions/bodies.js';
import { menuItem } from '../../actions/buttons.js';
import { bodyEntries } from '../../actions/context_menus.js';
import { goTo, keyFrames, stopPlaying } from '../../actions/playhead.js';
import { Stroke } from '../../controls/gesture.js';
import { heading, openMenuAt } from '../../controls/menu.js';
import { range } from '../../controls/words.js';
import { bodiesBeside, bodyNamed, posedBody } from '../../store/bodies.js';
import { clampFrame } from '../../store/clip.js';
import { select } from '../../store/parts.js';
import { server } from '../../store/state.js';
import { diamond, plate } from '../draw/glyphs.js';
import { frameAt, GUTTER, nearest, seenOf, snapped, x } from '../draw/scale.js';
import { held } from '../pointer.js';

/** @typedef {import('../../store/shapes.js').BodyOfScene} BodyOfScene */
/** @typedef {import('../../store/shapes.js').Bond} Bond */

const ROW = 20;
/** More rows are lower, so that the views keep their height: together, px. */
const FULL_ROWS = 4;
const ROWS = 90;
/** Names in lower rows than this would lie over each other, px. */
const NAMED = 9;
const LETTERS = 11;
/** From the line that letters stand on to their middle, as a share of their size. */
const CAP = 0.36;
/** Of what is drawn in a full row, px: keyframes, places to confirm, segments, bonds, a dot beside the name. */
const KEY = 4;
const RING = 4;
const BAR = 4;
const BOND = { y: 15, h: 3 };
const DOT = 3.5;
/** Of a low row's height at most. */
const MARK = 0.3;
const MIDDLE = 9;
const REACH_PX = 6;
const NAME_LETTERS = 15;

/** The bodies of the rows, in their order. @returns {BodyOfScene[]} */
function bodiesOfRows() {
  const posed = posedBody();
  return posed && bondsWith(posed.id).length ? [...bodiesBeside(), posed] : bodiesBeside();
}

/** How high each of so many rows is, px. */
export const rowHeight = (many) => (many > FULL_ROWS ? ROWS / many : ROW);

const row = () => rowHeight(bodiesOfRows().length);

/** A length of a full row in a row as it is now, px. */
const fitted = (px) => (px * row()) / ROW;

/** How large a mark is in a row as it is now, px. */
const markSize = (px) => Math.min(px, row() * MARK);

/** What the rows take, px. */
export const bodiesHeight = () => bodiesOfRows().length * row();

/** A bond between the posed body and another one, dragged by its ends. @type {import('../mark.js').Mark} */
export const bond = {
  kind: 'bond',
  row: 'bodies',
  layers: [
    {
      group: 'frames',
      z: 45,
      from: () => [server.bodies, server.bonds, held('bond')],
      draw: ({ rows }) =>
        rows.bodies ? bodiesOfRows().map((body, at) => drawBonds(body, topOf(rows.bodies, at))) : nothing,
    },
  ],
  hit(place, { rows }) {
    const { body, y } = rowAt(rows.bodies, place);
    if (!body || place.x < GUTTER || y < fitted(BOND.y - 2)) return null;
    const one = bondsWith(body.id).find(
      ({ first, last }) => place.x >= x(first) - REACH_PX && place.x <= x(last) + REACH_PX,
    );
    return one ? { index: one.index, end: endAt(one, place.x) } : null;
  },
  cursor: 'ew-resize',
  edits: true,
  grab({ index, end }, start) {
    const one = bondNumbered(index);
    if (!one) return null;
    const { first, last } = one;
    const offset = x(end === 'first' ? first : last) - start.x;
    const stroke = new Stroke('bond', (span) => ({ do: 'change_bond', index, ...span }));
    stopPlaying();
    return {
      move(place) {
        stroke.move({ [end]: clampFrame(snapped(place.x + offset, place.alt ? [] : keyFrames())) });
        return { index, end };
      },
      end: () => stroke.end(),
      cancel: () => stroke.cancel(),
    };
  },
  click({ index }) {
    const one = bondNumbered(index);
    if (!one) return;
    select(ownEnd(one).part);
    goTo(one.first);
  },
  menu({ index }, { page }) {
    const one = bondNumbered(index);
    if (one) {
      openMenuAt(
        'Hold',
        [heading(`${bondWords(one)} · ${range(one.first, one.last)}`), menuItem('letGo', index)],
        page,
      );
    }
  },
  tip: ({ index }, rows) => drawBondWords(bondNumbered(index), rows),
  drag: ({ index }, rows) => drawBondWords(bondNumbered(index), rows),
};

/** @type {import('../mark.js').Mark} */
export const bodyRow = {
  kind: 'body',
  row: 'bodies',
  layers: [
    {
      group: 'frames',
      z: 44,
      from: () => [server.bodies, server.bonds],
      draw: ({ rows }) =>
        rows.bodies ? bodiesOfRows().map((body, at) => drawRow(body, topOf(rows.bodies, at))) : nothing,
    },
    {
      group: 'above',
      z: 44,
      from: () => [server.bodies, server.bonds],
      draw: ({ rows }) =>
        rows.bodies ? bodiesOfRows().map((body, at) => drawName(body, topOf(rows.bodies, at))) : nothing,
    },
  ],
  hit(place, { rows }) {
    const { body } = rowAt(rows.bodies, place);
    return body ? { id: body.id, frame: frameMeant(body, place.x) } : null;
  },
  cursor: 'pointer',
  grab: () => ({ move: () => null }),
  click({ id, frame }) {
    stopPlaying();
    if (id !== posedBody()?.id) perform('poseBody', id);
    if (frame !== null) goTo(frame);
  },
  menu: ({ id }, { page }) => openMenuAt('Body', bodyEntries(id), page),
  tip({ id, frame }, rows) {
    const body = bodyNamed(id);
    if (!body || body.posed || !rows.bodies) return nothing;
    const where = frame === null ? '' : ` at ${frame}`;
    return plate(`Pose ${body.name}${where}`, frame === null ? 0 : x(frame), below(rows), ` · ${wordsOf(body)}`);
  },
};

/** "3 keyframes, 12 drafts, 2 places to confirm". @param {BodyOfScene} body */
function wordsOf(body) {
  return [posedWords(body), leftToDo(body)].filter(Boolean).join(', ');
}

const below = ({ bodies: box }) => box.y + box.h + 10;
const topOf = (box, at) => box.y + at * row();

/** The body whose row is at a place, and how far below its top that is. */
function rowAt(box, place) {
  const at = Math.floor((place.y - box.y) / row());
  return { body: bodiesOfRows()[at], y: place.y - topOf(box, at) };
}

/** Its keyframe or place to confirm near a pixel, else the frame there; null beside the frames. The posed body
 * has these elsewhere. */
function frameMeant({ keys, places, posed }, px) {
  if (px < GUTTER) return null;
  return nearest(posed ? [] : [...keys, ...places], px, REACH_PX) ?? clampFrame(frameAt(px));
}

const bondNumbered = (index) => (server.bonds ?? []).find((one) => one.index === index);

/** @param {Bond} one @returns {'first' | 'last'} */
const endAt = ({ first, last }, px) => (Math.abs(px - x(first)) < Math.abs(px - x(last)) ? 'first' : 'last');

/** "Left hand meets Racket · Grip" @param {Bond} one */
function bondWords(one) {
  const [own, other] = [ownEnd(one), otherEnd(one)];
  return `${own.label} meets ${other.name} · ${other.label}`;
}

/** That, over which frames, on a plate. @param {Bond | undefined} one */
function drawBondWords(one, rows) {
  if (!one || !rows.bodies) return nothing;
  return plate(bondWords(one), (x(one.first) + x(one.last)) / 2, below(rows), ` ${range(one.first, one.last)}`);
}

/** @param {BodyOfScene} body */
function drawRow(body, top) {
  const middle = top + fitted(MIDDLE);
  const rule = svg`<path class="rule" d=${`M${GUTTER} ${top + row() - 0.5}H100000`} />`;
  if (body.posed) return svg`<g class="bodyrow">${rule}</g>`;
  return svg`<g class="bodyrow" style="--body:${body.colour}">
    ${rule}
    ${seenOf(body.segments).map((one) => drawSegment(one, middle))}
    ${seenOf(body.places).map((at) => svg`<circle class="bodyplace" cx=${x(at)} cy=${middle} r=${markSize(RING)} />`)}
    ${seenOf(body.keys).map((at) => svg`<path class="bodykey" d=${diamond(x(at), middle, markSize(KEY))} />`)}
  </g>`;
}

function drawSegment({ first, last, state }, middle) {
  const kind = ['good', 'check', 'lost'].includes(state) ? `f-${state}` : 'open';
  return svg`<rect class="bodybar ${kind}" x=${x(first)} y=${middle - markSize(BAR) / 2} height=${markSize(BAR)}
    width=${Math.max(1, x(last) - x(first))} />`;
}

/** @param {BodyOfScene} body */
const drawBonds = ({ id }, top) => seenOf(bondsWith(id)).map((one) => drawBond(one, top));

/** @param {Bond} one */
const drawBond = ({ first, last }, top) => svg`<rect class="bond" x=${x(first - 0.3)} y=${top + fitted(BOND.y)} rx="1.5"
  width=${x(last + 0.3) - x(first - 0.3)} height=${markSize(BOND.h)} />`;

/** @param {BodyOfScene} body */
function drawName({ name, colour }, top) {
  const cut = name.length > NAME_LETTERS ? `${name.slice(0, NAME_LETTERS - 1)}…` : name;
  const middle = top + fitted(MIDDLE);
  const letters = Math.min(LETTERS, row());
  const words =
    row() < NAMED
      ? nothing
      : svg`<text class="lbl" x="24" y=${middle + letters * CAP}
    style="font-size:${letters}px">${cut}</text>`;
  return svg`<circle cx="15" cy=${middle} r=${Math.min(DOT, row() / 2)} style="fill:${colour}" />${words}`;
}
