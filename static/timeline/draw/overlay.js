// What moves over the rows: the playhead with its flag and the band of its interval; what is dragged
// or hovered, as the key on its way, the angle being changed, the mark under the pointer.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { server, ui } from '../../store/state.js';
import { partNamed } from '../../store/parts.js';
import { frameCount, lastFrame } from '../../store/clip.js';
import { clamp, shortNumber, signedNumber } from '../../controls/arithmetic.js';
import { BAR, GUTTER, right, RULER, x } from './scale.js';
import { around, frame, isKey, placesToConfirm, segmentAt, draftFrames } from '../../actions/playhead.js';
import { noteAt, noteAsOneLine } from '../../actions/keying.js';
import { noteMark } from './rulermarks.js';
import { reasonOf } from '../../actions/drafting.js';
import { partKeyAt } from '../../actions/parts.js';
import { isSelected, selectedKeys } from '../../actions/selection.js';
import { diamond } from './keymarks.js';
import { barOf } from './segments.js';
import { grabbed, hovered } from '../edit/pointer.js';
import { scale, valueAt } from './curve.js';
import { allPins, framesOf } from '../../actions/pins.js';
import { belowPin, proposalOf } from './pins.js';
import { drawBox, drawMovingKeys } from './selection.js';

export function flagWidth() {
  return 16 + 9 * String(frame()).length;
}

/** The playhead from the ruler down to `bottom`, a slider for those who cannot drag it. */
export function drawPlayhead(bottom) {
  if (frameCount() === 0) return nothing;
  const at = Math.round(x(frame()) * 2) / 2;
  if (at < GUTTER - 1 || at > right() + 12) return nothing;
  const half = flagWidth() / 2;
  return svg`<g class="playhead" role="slider" tabindex="0" aria-label="Frame"
      aria-valuemin="0" aria-valuemax=${lastFrame()} aria-valuenow=${frame()}
      aria-valuetext=${spokenFrame()} transform=${`translate(${at} 0)`}>
    <path class="stem" d=${`M0 ${RULER - 4}V${bottom}`} />
    <path class="ring" d=${flag(half + 3, -3, 20)} />
    <path class="flag" d=${flag(half, 0, 17)} />
    <text x="0" y="12.5" text-anchor="middle">${frame()}</text></g>`;
}

function flag(half, top, bottom) {
  return `M${-half} ${top + 3}a3 3 0 0 1 3-3h${2 * half - 6}a3 3 0 0 1 3 3V${bottom - 3}a3 3 0 0 1-3 3
    h${7 - half}l-4 4-4-4h${7 - half}a3 3 0 0 1-3-3z`;
}

function spokenFrame() {
  const at = frame();
  const part = partKeyAt(at) ? `, part keyframe, ${partKeyAt(at).words}` : '';
  const what = isKey(at) ? `, keyframe${isSelected(at) ? ', selected' : ''}` : draftFrames().includes(at) ? ', draft' : part;
  const segment = segmentAt(at);
  const note = noteAt(at);
  const noted = note ? `, note: ${noteAsOneLine(note, HOVERED)}` : '';
  return `Frame ${at} of ${lastFrame()}${what}${noted}${segment?.words ? `. ${segment.words}` : ''}`;
}

/** The interval around the playhead; on a key, both intervals it ends. */
export function drawBand(rows, bottom) {
  const interval = server.keys ? around(frame()) : null;
  if (interval === null || interval[0] === interval[1]) return nothing;
  const [from, to] = interval.map(x);
  return svg`<rect class="band" x=${from} y=${rows.top} width=${to - from}
    height=${Math.max(0, bottom - rows.top)} />`;
}

const LETTER_PX = 6.6;
/** Letters of a note that are shown where it is pointed at. */
const HOVERED = 90;

export function drawGrabbed(rows) {
  const what = grabbed();
  if (what?.kind === 'key') return drawMovingKey(what, rows);
  if (what?.kind === 'note') return drawMovingNote(what);
  if (what?.kind === 'keys') return drawMovingKeys(what, rows, label);
  if (what?.kind === 'span') return label(`${what.end === 'first' ? 'In' : 'Out'} ${ui.span[what.end]}`, x(ui.span[what.end]), RULER + 12);
  if (what?.kind === 'box') return drawBox(what, rows);
  if (what?.kind === 'pin') return drawPinDrag(what, rows);
  if (what?.kind === 'angle') return drawAngle(what, rows);
  return what === null ? drawHover(rows) : nothing;
}

function drawMovingKey({ from, to, copy, taken, refused }, rows) {
  const middle = rows.keys.middle;
  const words = taken ? `${to} is a ${partKeyAt(to) ? 'part ' : ''}keyframe` : `${from} ${copy ? '+' : '→'} ${to}`;
  const home = copy ? nothing : svg`<path class="home" d=${diamond(x(from), middle, 5)} />`;
  return svg`${home}<g class=${refused ? 'shake' : ''}>
      <path class=${`moving${taken ? ' taken' : ''}`} d=${diamond(x(to), middle, 8)} /></g>
    ${label(words, x(to), middle + 22)}`;
}

function drawMovingNote({ from, to, taken }) {
  const words = taken ? `${to} has a note` : `${from} → ${to}`;
  return svg`<path class=${`note moving${taken ? ' taken' : ''}`} d=${noteMark(x(to), 5, 10)} />
    ${label(words, x(to), RULER + 12)}`;
}

/** "Left foot 0–66 was 71". */
function drawPinDrag({ index, end, from }, rows) {
  const pin = allPins()[index];
  if (!pin || !rows.pins || rows.pins.thin) return nothing;
  const isSame = pin.first === from.first && pin.last === from.last;
  const was = end === 'middle' ? framesOf(from) : from[end];
  const words = `${pin.label} ${framesOf(pin)}`;
  const at = end === 'middle' ? (x(pin.first) + x(pin.last)) / 2 : x(pin[end]);
  return label(words, at + (end === 'last' ? 60 : end === 'first' ? -60 : 0), belowPin(rows.pins, pin), isSame ? '' : ` was ${was}`);
}

function drawAngle({ frame: key, part, axis, from, deg }, rows) {
  const at = rows.curve === null ? null : scale(rows.curve);
  if (at === null) return nothing;
  const y = clamp(at.y(deg), rows.curve.y, rows.curve.y + rows.curve.h);
  const word = partNamed(part)?.words?.[axis] ?? axis.toUpperCase();
  const words = `${word} ${shortNumber(deg, 1)}°  ${signedNumber(deg - from, 1)}`;
  return svg`<path class="curvekey current" d=${diamond(x(key), y, 6)} />
    ${beside(words, x(key), y, rows)}`;
}

/** Words beside a point of the curve, on the side where there is room. */
function beside(words, at, y, rows) {
  const half = (words.length * LETTER_PX) / 2 + 7;
  const side = at + 2 * half + 24 > right() ? -1 : 1;
  const low = rows.curve.y + rows.curve.h - 10;
  return label(words, at + side * (half + 12), clamp(y, rows.curve.y + 8, low));
}

/** Words on a small plate, kept within the drawing; `more` follows them quietly. */
function label(words, at, y, more = '') {
  const wide = (words.length + more.length) * LETTER_PX + 14;
  const centre = clamp(at, GUTTER + 4 + wide / 2, right() + 22 - wide / 2);
  return svg`<g class="plate"><rect x=${centre - wide / 2} y=${y - 10} width=${wide} height="20" rx="4" />
    <text x=${centre} y=${y + 4} text-anchor="middle">${words}${more ? svg`<tspan class="more">${more}</tspan>` : nothing}</text></g>`;
}

function drawHover(rows) {
  const what = hovered();
  if (what === null) return nothing;
  const middle = rows.keys.middle;
  if (what.kind === 'key' && partKeyAt(what.frame)) return drawPartHover(what.frame, middle);
  if (what.kind === 'key') {
    return svg`<path class="hover" d=${diamond(x(what.frame), middle, 9.5)} />
      ${label(`Keyframe ${what.frame}`, x(what.frame), middle + 23)}`;
  }
  if (what.kind === 'grip') return drawGripHover(what, rows);
  if (what.kind === 'pin' || what.kind === 'proposal') return drawPinHover(what, rows);
  if (what.kind === 'note') return drawNoteHover(what.frame);
  if (what.kind === 'place') return drawPlaceHover(what.frame, rows);
  if (what.kind === 'curvekey') return drawCurveHover(what.frame, rows);
  const segment = (server.segments ?? []).find(({ first }) => first === what.first);
  if (!segment) return nothing;
  const { from, to } = barOf(segment);
  return svg`<rect class="hover" x=${from - 1.5} y=${middle - BAR.half - 1.5} rx="4"
    width=${Math.max(1, to - from) + 3} height=${2 * BAR.half + 3} />`;
}

function drawPartHover(at, middle) {
  const here = x(at);
  return svg`<path class="hover" d=${diamond(here, middle, 10.5)} />
    ${label(`Part keyframe ${at}`, here, middle + 23, `  ${partKeyAt(at).words}`)}
    ${label('', here, middle + 44, 'The other parts follow tracking here. Double-click to key the whole pose.')}`;
}

function drawGripHover({ end }, rows) {
  const frames = selectedKeys();
  const at = end === 'first' ? frames[0] : frames.at(-1);
  return at === undefined ? nothing : label('Drag to stretch', x(at), rows.keys.middle + 23);
}

function drawPinHover(what, rows) {
  const set = what.kind === 'pin' ? allPins()[what.index] : undefined;
  const pin = set ?? proposalOf(what);
  if (!pin || !rows.pins) return nothing;
  const more = set ? '' : ' proposed · double-click to accept';
  const words = set?.problem || `${pin.label} ${framesOf(pin)}${more}`;
  return label(words, (x(pin.first) + x(pin.last)) / 2, belowPin(rows.pins, pin));
}

function drawNoteHover(at) {
  const note = noteAt(at);
  if (!note) return nothing;
  return svg`<path class="note hover" d=${noteMark(x(at), 5, 10)} />
    ${label(`${at}  ${noteAsOneLine(note, HOVERED)}`, x(at), RULER + 12)}`;
}

function drawPlaceHover(at, rows) {
  const place = placesToConfirm().find((each) => each.frame === at);
  if (!place) return nothing;
  return label(`${reasonOf(place)}. Go to ${at}`, x(at), rows.keys.middle + 23);
}

function drawCurveHover(key, rows) {
  const at = rows.curve === null ? null : scale(rows.curve);
  const value = valueAt(key);
  if (at === null || value === null) return nothing;
  const y = at.y(value);
  return svg`<path class="hover" d=${diamond(x(key), y, 7)} />
    ${beside(`${shortNumber(value, 1)}°`, x(key), y, rows)}`;
}
