// The chart of a joint's angle, left and right, over the timeline and in step with it: its frames stand
// over the timeline's, a press or a drag moves the playhead.

import { html, nothing, render, svg } from '../vendor/lit-html/lit-html.js';
import { angleRange, SIDES, STEPS, ticksOf } from '../actions/angle_picture.js';
import { chartAngle, closeAngle, degrees, extremes, saveAnglePicture, saveAngleTable } from '../actions/angles.js';
import { frame, goTo, stopPlaying } from '../actions/playhead.js';
import { clamp } from '../controls/arithmetic.js';
import { button, dropdown, iconButton } from '../controls/fields.js';
import { clampFrame } from '../store/clip.js';
import { server, watch } from '../store/state.js';
import { GUTTER, frameAt, right, visible, x } from './draw/scale.js';
import { line, runsOf } from './draw/series.js';

/** Of the chart, where there is room; less in a low window. */
const HEIGHT = 144;
const LEAST_HEIGHT = 72;
const AIR = 14;
/** Half of what a value takes at the right end. */
const END_PX = 14;
/** Above the card the ruler and the row of keyframes stay in sight. */
const RULER_PX = 60;
/** What of the card is not the chart, px. */
const AROUND_PX = 52;

let place = null;
let drawing = null;

/** Draw the card in this element, over the timeline's drawing. */
export function mountAngleCard(element, timeline) {
  [place, drawing] = [element, timeline];
  watch(['joint_angle', 'view', 'u:timeSize', 'u:timeWindow', 'u:timeHead', 'u:playing', 'reduction'], draw);
  addEventListener('resize', () => requestAnimationFrame(put));
}

function draw() {
  // The timeline is higher meanwhile, by what the chart needs.
  document.documentElement.dataset.chart = server.joint_angle && !server.reduction ? 'yes' : 'no';
  render(server.joint_angle && !server.reduction ? card(server.joint_angle) : nothing, place);
  put();
}

/** As wide as the timeline, over its lanes: the picture, and the frames, stay in sight. */
function put() {
  const shown = place.firstElementChild;
  if (!shown) return;
  const box = drawing.getBoundingClientRect();
  shown.style.left = `${box.left}px`;
  shown.style.width = `${box.width}px`;
  shown.style.top = `${Math.max(box.top + RULER_PX, box.bottom - shown.getBoundingClientRect().height)}px`;
}

/** What fits below the rows that stay, whole above the status bar. */
const chartHeight = () => clamp(drawing.getBoundingClientRect().height - RULER_PX - AROUND_PX, LEAST_HEIGHT, HEIGHT);

function card(shown) {
  const { sides, choices, positive, negative, joint, angle } = shown;
  const value = `${joint} ${angle}`;
  const options = choices.map((each) => ({ id: `${each.joint} ${each.angle}`, label: each.label }));
  return html`<section class="menu stack anglecard" aria-label=${`${shown.label} over time`}>
    <div class="row">
      ${dropdown({ label: 'Joint angle', value, kind: 'field', options, act: (id) => chartAngle(...id.split(' ')) })}
      <span class="dim">+ ${positive}, − ${negative}</span><span class="sp"></span>
      ${sides.map(sideNow)}
      ${button({
        name: 'img',
        label: 'Save picture',
        title: 'Save the whole curve as a PNG picture',
        kind: 'sm',
        act: saveAnglePicture,
      })}
      ${button({
        name: 'exp',
        label: 'Save CSV',
        title: 'Save frames, seconds and degrees as a table',
        kind: 'sm',
        act: saveAngleTable,
      })}
      ${iconButton({ name: 'x', label: 'Close', act: closeAngle })}
    </div>
    ${chart(shown)}
  </section>`;
}

/** Where the side is at the playhead, and between which values it moves. */
function sideNow({ side, values, errors }) {
  const off = errors?.[frame()] ?? null;
  const found = extremes(values);
  const range = found ? `${degrees(found.low.value)} to ${degrees(found.high.value)}` : '';
  return html`<span class="side ${side}"><span class="dim">${SIDES[side]}</span> <b class="num">${degrees(values[frame()])}</b>
    ${
      off === null
        ? nothing
        : html`<span class="dim num"
      title="Half of all are off by less">± ${degrees(off)} ·</span>`
    }
    <span class="dim num">${range}</span></span>`;
}

function chart(shown) {
  if (!shown.sides.some(({ values }) => extremes(values))) return html`<p class="note">No pose is known yet.</p>`;
  const [low, high] = angleRange(shown);
  const height = chartHeight();
  const y = (value) => AIR + ((high - value) * (height - 2 * AIR)) / (high - low);
  const { first, last } = visible();
  const at = x(frame());
  return html`<svg class="anglechart" height=${height} role="img" aria-label=${`${shown.label}, degrees`}
      @pointerdown=${press} @pointermove=${drag}>
    ${ticksOf(low, high, STEPS, 6).map(
      (
        value,
      ) => svg`<line class="tick ${value === 0 ? 'zero' : ''}" x1=${GUTTER} x2=${right()} y1=${y(value)} y2=${y(value)}
        />
      <text x=${GUTTER - 8} y=${y(value) + 4}>${value}°</text>`,
    )}
    ${shown.sides.map(({ side, values, errors }) =>
      bands(values, errors).map(
        (d) => svg`<path class="band ${side}"
      d=${d(y)} />`,
      ),
    )}
    ${shown.sides.map((each) =>
      curves(each, shown.guess).map(
        ([kind, run]) => svg`<path class="curve ${kind}"
      d=${line(run, y)} />`,
      ),
    )}
    ${shown.sides.map(({ side, values }) => ends(side, values, y, first, last))}
    <line class="now" x1=${at} x2=${at} y1="0" y2=${height} />
    ${shown.sides.map(({ side, values }) => now(side, values[frame()], at, y))}
  </svg>`;
}

/** What of a side's curve is sure, and what is not seen or a guess in depth: the class of each, and its run. */
function curves({ side, values, errors }, guess) {
  if (!errors) return runsOf(values).map((run) => [side, run]);
  const isGuess = (at) => (errors[at] ?? 0) > guess;
  const near = (at) => isGuess(at - 1) || isGuess(at) || isGuess(at + 1); // so that both lines meet
  const guessed = values.map((value, at) => (near(at) ? value : null));
  const sure = values.map((value, at) => (isGuess(at) ? null : value));
  return [...runsOf(guessed).map((run) => ['guess', run]), ...runsOf(sure).map((run) => [side, run])];
}

/** By how much a side's values are expected to be off, around them: path data by the vertical scale. */
function bands(values, errors) {
  if (!errors) return [];
  const beside = (sign) =>
    values.map((value, at) => (value === null || (errors[at] ?? null) === null ? null : value + sign * errors[at]));
  const above = runsOf(beside(1));
  return runsOf(beside(-1)).map(
    (below, at) => (y) => `${line(above[at], y)}L${line([...below].reverse(), y).slice(1)}Z`,
  );
}

/** The lowest and the highest value, where they are. */
function ends(side, values, y, first, last) {
  const found = extremes(values);
  if (!found) return nothing;
  return [found.low, found.high]
    .filter((one) => one.frame >= first && one.frame <= last)
    .map(
      (one) => svg`<g class="end ${side}">
    <circle cx=${x(one.frame)} cy=${y(one.value)} r="3.5" />
    <text x=${Math.min(x(one.frame), right() - END_PX)}
      y=${y(one.value) + (one === found.high ? -8 : 17)}>${degrees(one.value)}</text></g>`,
    );
}

function now(side, value, at, y) {
  if (value === null || value === undefined) return nothing;
  return svg`<circle class="now ${side}" cx=${at} cy=${y(value)} r="4.5" />`;
}

function press(event) {
  if (event.button !== 0) return;
  event.currentTarget.setPointerCapture(event.pointerId);
  stopPlaying();
  follow(event);
}

function drag(event) {
  if (event.currentTarget.hasPointerCapture(event.pointerId)) follow(event);
}

function follow(event) {
  const { left } = event.currentTarget.getBoundingClientRect();
  goTo(clampFrame(frameAt(event.clientX - left)));
}
