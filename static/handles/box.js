// Drawing the box around a person: dragged over the picture, then pulled at its grips or moved. It is
// there as long as its tool is in hand. Before that, whoever was found in the picture is outlined, and taken with
// a click.

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../store/state.js';
import { perform, whyNot } from '../actions/actions.js';
import { runToDraft, setDraftRange, smallWords, whom } from '../actions/drafting.js';
import { peopleHere, peopleWords, personAt, personMeant, takePerson } from '../actions/people.js';
import { goTo, stopPlaying } from '../actions/playhead.js';
import { keepsKey } from '../controls/focus.js';
import { interaction, leaveSketch } from './interaction.js';
import { between, clipped, CURSORS, gripsOf, holds, moved, pulled, sizeOf } from './box_shape.js';
import { distance } from './space.js';

const GRIP_PX = 8;
const REACH_PX = 12;
const BEGINS_PX = 4;
const LABEL_PX = 30;
const LABEL_WIDTH_PX = 132;
const KEY_STEPS = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, -1], arrowdown: [0, 1] };
/** Of the picture's longer side. */
const KEY_STEP = 0.01;
const LOWER_RIGHT = 4;

/** @typedef {import('./box_shape.js').Box} Box */
/** @typedef {import('./box_shape.js').Spot} Spot */

/**
 * The picture reaches from −0.5 to width − 0.5.
 * @returns {Box}
 */
function bounds() {
  const { width, height } = server.camera;
  return [-0.5, -0.5, width - 0.5, height - 0.5];
}

const shownIn = (view, one) => between(view.fromView(one.slice(0, 2)), view.fromView(one.slice(2)));
const onScreen = (view) => shownIn(view, ui.box);

/** The grip under a place of the view, or null. */
function gripAt(view, at) {
  if (!ui.box || !at) return null;
  const away = gripsOf(onScreen(view)).map((grip) => distance(grip, at));
  const nearest = away.indexOf(Math.min(...away));
  return away[nearest] <= REACH_PX ? nearest : null;
}

const isInside = (view, at) => Boolean(ui.box && at && holds(onScreen(view), at));

/** @type {import('./drawing_tool.js').Tool} */
export const box = {
  icon: 'wand',
  hints: [
    ['Drag', 'draw the box, pull its edges'],
    ['Alt ← ↑ → ↓', 'move, with Shift resize'],
    ['← →', 'choose another frame'],
    ['Enter', 'draft'],
    ['Esc', 'cancel'],
  ],
  /** In the guide its card says it, beside the picture. */
  words() {
    if (Number.isInteger(ui.guideStep) && ui.guidePath === 'film') return '';
    if (!ui.box) return peopleWords() || `Drag a box around ${whom()}, from head to toes.`;
    return smallWords() || 'Press Enter to draft. Drag the edges to correct the box.';
  },
  /** On a grip, inside, or where a new box begins. */
  down(view, x, y) {
    const grip = gripAt(view, [x, y]);
    const kind = grip !== null ? 'grip' : isInside(view, [x, y]) ? 'move' : 'new';
    interaction.sketch.hold = { kind, grip, from: view.toView([x, y]), at: [x, y], before: ui.box };
  },
  move,
  /** What has no size is no box; a click takes the person there. */
  up(view, x, y) {
    move(view, x, y);
    const { hold } = interaction.sketch;
    if (hold && !hold.begun) takePerson(personAt(view.toView([x, y])));
    if (hold?.begun && Math.min(...sizeOf(onScreen(view))) < BEGINS_PX) setUi('box', hold.before);
    interaction.sketch.hold = null;
  },
  /** As it was before the press. */
  cancel() {
    const { hold } = interaction.sketch;
    if (hold) setUi('box', hold.before);
    interaction.sketch.hold = null;
  },
  key: (event, name) => (name === 'enter' ? enter(event.shiftKey) : moveByKey(event, name)),
  cursor(view) {
    const { hold, pointer } = interaction.sketch;
    const grip = hold ? hold.grip : gripAt(view, pointer);
    if (grip !== null) return CURSORS[grip];
    if (!hold && ui.personHover) return 'pointer';
    return (hold ? hold.kind === 'move' : isInside(view, pointer)) ? 'move' : 'crosshair';
  },
  draw,
  label,
};

/** The pointer moved, with something in hand or not. */
function move(view, x, y) {
  const { hold } = interaction.sketch;
  setUi('personHover', hold?.begun ? null : personAt(view.toView([x, y])));
  if (!hold || (!hold.begun && distance(hold.at, [x, y]) < BEGINS_PX)) return;
  hold.begun = true;
  setUi('box', changed(hold, view.toView([x, y])));
}

function changed({ kind, grip, from, before }, to) {
  if (kind === 'new') return clipped(between(from, to), bounds());
  /** @type {Spot} */
  const by = [to[0] - from[0], to[1] - from[1]];
  return kind === 'move' ? moved(before, by, bounds()) : clipped(pulled(before, grip, by), bounds());
}

/** Alt with an arrow key moves the box, with Shift its lower right corner; true when it was one of these. */
function moveByKey({ altKey, shiftKey }, name) {
  const way = KEY_STEPS[name];
  if (!altKey || !way) return false;
  const { width, height } = server.camera;
  const step = Math.max(1, Math.round(KEY_STEP * Math.max(width, height)));
  /** @type {Spot} */
  const by = [way[0] * step, way[1] * step];
  /** @type {Box} */
  const now = ui.box ?? [0.35 * width, 0.1 * height, 0.65 * width, 0.9 * height];
  setUi('box', shiftKey ? clipped(pulled(now, LOWER_RIGHT, by), bounds()) : moved(now, by, bounds()));
  return true;
}

/** Enter on a control that was reached with Tab is that control's. */
function enter(isForAll) {
  if (keepsKey('Enter') || !(ui.box || personMeant())) return false;
  if (isForAll && peopleHere().length > 1) draftEverybody();
  else if (ui.box) draftFromBox();
  else takePerson();
  return true;
}

/** Draft from the box, which is done with. */
export const draftFromBox = () => draftBy('draft');

/** Draft everybody who was found. */
export const draftEverybody = () => draftBy('draftAll');

/** @param {'draft' | 'draftAll'} action */
function draftBy(action) {
  const why = whyNot(action);
  perform(action);
  if (why) return;
  setUi('draftRange', null);
  leaveSketch();
}

/** Draw a box at a frame, for the frames there that have no draft. */
export function drawBoxAt(frame) {
  setDraftRange(...runToDraft(server.draft.missing));
  stopPlaying();
  goTo(frame);
  setUi('tool', 'box');
}

/** Whoever was found: thin, the one who is pointed at brighter, and the one who is meant. */
function drawPeople(view) {
  const meant = personMeant();
  return svg`<g class="box people">${peopleHere().map((person) => {
    const [left, top, right, bottom] = shownIn(view, person);
    const kind = person === ui.personHover ? 'hot' : person === meant ? 'meant' : '';
    return svg`<rect class="found-edge" x=${left} y=${top} width=${right - left} height=${bottom - top} rx="2" />
      <rect class="found ${kind}" x=${left} y=${top} width=${right - left} height=${bottom - top} rx="2" />`;
  })}</g>`;
}

function draw(view) {
  if (!ui.box) return drawPeople(view);
  const [left, top, right, bottom] = onScreen(view);
  const { clientWidth: width, clientHeight: height } = view.el;
  const hole = `M0 0H${width}V${height}H0ZM${left} ${top}V${bottom}H${right}V${top}Z`;
  const hot = interaction.sketch.hold?.grip ?? gripAt(view, interaction.sketch.pointer);
  return svg`<g class="box ${smallWords() ? 'small' : ''}">
    <path class="outside" fill-rule="evenodd" d=${hole} />
    <rect class="edge" x=${left} y=${top} width=${right - left} height=${bottom - top} />
    ${gripsOf([left, top, right, bottom]).map(
      ([x, y], i) => svg`<rect class="pull ${i === hot ? 'hot' : ''}"
      x=${x - GRIP_PX / 2} y=${y - GRIP_PX / 2} width=${GRIP_PX} height=${GRIP_PX} rx="1" data-pull=${i} />`,
    )}
  </g>`;
}

/** "118 × 246": the size of a box. */
export const sizeWords = (one) => sizeOf(one).map(Math.round).join(' × ');

/** Its size above it; below its upper edge where there is no room. */
function label(view) {
  if (!ui.box) return nothing;
  const [left, top] = onScreen(view);
  const x = Math.max(8, Math.min(left, view.el.clientWidth - LABEL_WIDTH_PX));
  const y = top - LABEL_PX < 8 ? Math.max(8, top + 8) : top - LABEL_PX;
  return html`<div class="flt num"
    style="left:${x}px;top:${y}px">Person <span class="mut">${sizeWords(ui.box)}</span></div>`;
}
