// The card of a reduction, over the timeline that shows its keyframes: how many there may be, or how
// far they may be off, what there would be, and the answer.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import {
  applyReduction,
  discardReduction,
  isReducing,
  limbToReduce,
  reductionMessage,
  USUAL,
} from '../actions/proposals.js';
import { checkbox, numberField, segmented, slider } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { standAt } from '../controls/menu.js';
import { count, range } from '../controls/words.js';
import { partNamed } from '../store/parts.js';
import { send } from '../store/link.js';
import { server, watch } from '../store/state.js';

const ABOVE_PX = 8;
const SOURCES = { tracked: 'Tracked', drafts: 'Drafted', imported: 'Imported' };
const OFF = 'How far any point of the body may be off where keyframes alone are interpolated';
const UNITS = {
  every: {
    id: 'every',
    label: 'Frames',
    name: 'One keyframe in',
    title: 'As few as you like: the motion stays as it is between them',
    least: 2,
    most: 200,
    of: 'frames',
    about: 'How many frames one keyframe stands for',
  },
  cm: {
    id: 'cm',
    label: 'cm',
    name: 'Tolerance',
    title: 'As many as interpolation needs, in space',
    least: 0.5,
    most: 50,
    of: 'cm',
    about: OFF,
  },
  px: {
    id: 'px',
    label: 'px',
    name: 'Tolerance',
    title: 'As many as interpolation needs, in the picture',
    least: 0.5,
    most: 200,
    of: 'px',
    about: OFF,
  },
};

let place = null;
let drawing = null;

/** Draw the card in this element, over the timeline's drawing. */
export function mountReduceCard(element, timeline) {
  [place, drawing] = [element, timeline];
  watch(['reduction', 'view', 'body', 'keys', 'u:timeSize'], draw);
  addEventListener('resize', () => requestAnimationFrame(put));
}

function draw() {
  render(isReducing() ? card() : nothing, place);
  put();
}

/** Over the middle of the timeline. */
function put() {
  const shown = place.firstElementChild;
  if (!shown) return;
  const box = drawing.getBoundingClientRect();
  const { width, height } = shown.getBoundingClientRect();
  standAt(shown, box.left + (box.width - width) / 2, Math.max(ABOVE_PX, box.top - height - ABOVE_PX));
}

function card() {
  const { first, last, source, busy, limbs } = server.reduction;
  return html`<div class="menu stack reducecard" role="dialog" aria-label="Reduce to keyframes">
    <div class="row"><span class="i14">${icon('mid')}</span><b>Reduce to keyframes</b><span class="sp"></span>
      <span class="dim num">${SOURCES[source]} ${range(first, last)}</span></div>
    ${goal()}
    <p class="found" aria-live="polite">${found()}</p>
    ${limb()}${replacing()}
    <div class="row"><span class="dim hint">${
      limbs.length ? '' : 'The motion between them stays as it is.'
    }</span><span class="sp"></span>
      <button class="btn sm ghost" @click=${discardReduction}>Cancel<kbd>Esc</kbd></button>
      <button class="btn sm pri ${busy ? 'off' : ''}" aria-disabled=${busy ? 'true' : nothing}
        @click=${applyReduction}>Reduce<kbd>Enter</kbd></button></div>
  </div>`;
}

/** What counts: two tolerances at once are possible from the command line alone. */
function unit() {
  const { goal: every, cm } = server.reduction;
  if (every !== null) return UNITS.every;
  return cm === null ? UNITS.px : UNITS.cm;
}

function goal() {
  const { id, name, least, most, of, about } = unit();
  const whole = id === 'every';
  const spec = {
    key: `reduce.${id}`,
    label: name,
    value: whole ? server.reduction.goal : server.reduction[id],
    unit: of,
    decimals: whole ? 0 : 1,
    step: whole ? 1 : 0.1,
    coarse: whole ? 10 : 1,
    perPixel: whole ? 0.5 : 0.1,
    min: least,
    max: most,
    edit: (value) => reductionMessage({ [id]: whole ? Math.round(value) : value }),
  };
  return html`<div class="row tolerance"><label>${name}</label>
    ${slider({ ...spec, zero: least, tick: false, log: true, title: about })}
    ${numberField(spec)}
    ${segmented({
      label: 'Asked for in',
      value: id,
      options: Object.values(UNITS),
      act: (other) => send(reductionMessage({ every: null, cm: null, px: null, [other]: USUAL[other] })),
    })}</div>`;
}

function found() {
  const { frames, kept, every, busy, off_cm: cm, off_px: px, gaps, limbs } = server.reduction;
  if (!frames.length) return 'Working…';
  const before = kept ? ` (${kept} there before)` : '';
  const off = cm === null ? `${px?.toFixed(1)} px` : `${cm.toFixed(1)} cm`;
  const alone = limbs.length ? `Off by ${off} at most.` : `Interpolation alone would be off by ${off} at most.`;
  const bridged = gaps ? ` ${count(gaps, 'frame')} without a pose.` : '';
  return html`<b class="num">${count(frames.length, 'keyframe')}</b>${before}, one in ${every.toFixed(1)} frames. ${alone}${bridged}${busy ? ' …' : ''}`;
}

/** The selected limb by itself, as part keyframes between the keyframes. */
function limb() {
  const { limbs } = server.reduction;
  const part = limbs.length ? partNamed(limbs[0]) : limbToReduce();
  if (!part || server.keys.frames.length < 2) return nothing;
  return checkbox({
    label: `Only the limb of the ${part.label.toLowerCase()}`,
    on: limbs.length > 0,
    title: 'Part keyframes of this limb; the rest of the body stays as it is',
    act: (on) => send(reductionMessage({ limbs: on ? [part.name] : [] })),
  });
}

function replacing() {
  const { first, last, limbs, replacing: on } = server.reduction;
  const own = server.keys.frames.filter((frame) => first < frame && frame < last);
  if (!own.length || limbs.length) return nothing;
  return checkbox({
    label: 'May remove keyframes that are there',
    on,
    title: `Of ${count(own.length, 'keyframe')}, those that the motion does not need`,
    act: (value) => send(reductionMessage({ replacing: value })),
  });
}
