// The top of the inspector: the figure or the tree of parts, and what is selected. Drawn 100 × 148;
// limbs are capsules (x1, y1, x2, y2, half width 1, half width 2).

import { html, nothing, svg } from '../vendor/lit-html/lit-html.js';
import { perform } from '../actions/actions.js';
import { actionIcon } from '../actions/buttons.js';
import { alongChain, otherSide, remember } from '../actions/parts.js';
import { isTracked } from '../actions/tracking.js';
import { dropdown } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { range } from '../controls/words.js';
import { ancestors, childrenOf, partNamed, select, selectedPart } from '../store/parts.js';
import { server, setUi, ui } from '../store/state.js';
import { isSurface, words } from '../store/clip.js';

const MIDDLE = 56;

const TRUNK = {
  head: 'M49.5 6.5a6.5 6.5 0 0 1 13 0l-1 9a5.5 5.5 0 0 1-11 0z',
  neck: 'M53 19h6v5h-6z',
  chest: 'M45 25h22a3 3 0 0 1 3 3.5l-3 19H45l-3-19A3 3 0 0 1 45 25z',
  waist: 'M45.4 49h21.2l2 13a3 3 0 0 1-3 3H46.4a3 3 0 0 1-3-3z',
};

/** On the shoulders of bodies that have them. */
const GIRDLE = { clavicle: [3, 27.4, 10.5, 27.6, 1.5, 1.7] };

const LIMBS = {
  upper_arm: [15, 29, 25, 50, 4.4, 3.8],
  forearm: [25.5, 52, 31, 72, 3.7, 2.9],
  hand: [31.6, 75, 34, 84, 3.2, 2.6],
  thigh: [7.5, 68, 9, 94, 6.2, 4.6],
  shin: [9.2, 98, 9.6, 121, 4.4, 3.2],
  foot: [9.8, 125, 13, 128, 3.2, 2.6],
};

const OUTLINES = outlines();

/** Whether this body is the person the figure shows. */
export function isPerson(body) {
  const names = new Set(body.parts.map((part) => part.name));
  const shown = Object.keys(OUTLINES).filter((name) => !name.endsWith('_clavicle'));
  return body.parts.every((part) => part.name in OUTLINES) && shown.every((name) => names.has(name));
}

/** face(part) → {selected, hovered, over(), out(), act()}. */
export function figure(body, face) {
  const parts = body.parts.map((part) => ({ part, look: face(part) }));
  const lit = (kind) => parts.filter(({ look }) => look[kind]).map(({ part }) => outline(part, kind));
  return html`<svg class="person" viewBox="6 -7 100 148" role="group" aria-label="Parts">
    ${parts.map(shape)}${lit('hovered')}${lit('selected')}
    <text x="14" y="131">R</text>
    <text x="93" y="131">L</text>
  </svg>`;
}

function shape({ part, look }) {
  return svg`<path d=${OUTLINES[part.name]} class="part ${part.side}" role="button"
    tabindex=${look.first ? 0 : -1} aria-label=${part.label} aria-pressed=${look.selected}
    @pointerenter=${look.over} @pointerleave=${look.out} @click=${look.act}><title>${part.label}</title></path>`;
}

/** What is lit is drawn once more on top, so that its outline hides nowhere. */
function outline(part, kind) {
  return svg`<path d=${OUTLINES[part.name]} class="part ${part.side} ${kind}"></path>`;
}

function outlines() {
  const all = { ...TRUNK };
  for (const [name, numbers] of Object.entries({ ...LIMBS, ...GIRDLE })) {
    all[`left_${name}`] = capsule(numbers, 1);
    all[`right_${name}`] = capsule(numbers, -1);
  }
  return all;
}

/** @param {number[]} numbers */
function capsule([dx1, y1, dx2, y2, w1, w2], side) {
  const x1 = MIDDLE + side * dx1;
  const x2 = MIDDLE + side * dx2;
  const angle = Math.atan2(y2 - y1, x2 - x1);
  const [nx, ny] = [-Math.sin(angle), Math.cos(angle)];
  const at = (x, y, w) => `${(x + nx * w).toFixed(2)} ${(y + ny * w).toFixed(2)}`;
  return (
    `M${at(x1, y1, w1)}A${w1} ${w1} 0 0 1 ${at(x1, y1, -w1)}` +
    `L${at(x2, y2, -w2)}A${w2} ${w2} 0 0 1 ${at(x2, y2, w2)}Z`
  );
}

const HIDDEN = 0.35;
const PARTLY = 0.65;

/** How well a part is seen at the present frame, as a sentence. */
export function seenHere(part) {
  if (!part.parent && !lane(part)) return 'Moves the whole body';
  const value = lane(part)?.[server.view.frame];
  if (value === undefined || value === null) return restWord(part);
  const percent = `${Math.round(value * 100)} %`;
  if (value < HIDDEN) return `Hidden here: ${percent}`;
  return value < PARTLY ? `Partly visible here: ${percent}` : `Clearly visible here: ${percent}`;
}

/** The runs of frames [first, last] in which the part is hidden. */
export function hiddenRuns(part) {
  const runs = [];
  (lane(part) ?? []).forEach((value, frame) => {
    if (value === null || value >= HIDDEN) return;
    const last = runs.at(-1);
    if (last && last[1] === frame - 1) last[1] = frame;
    else runs.push([frame, frame]);
  });
  return runs;
}

/** Whether a segment holds a frame, and its motion, stopped midway, has come so far. */
function reaches({ first, last, unreached }, frame) {
  const isBeyond = unreached && unreached[0] <= frame && frame <= unreached[1];
  return first <= frame && frame <= last && !isBeyond;
}

/** "7", or "7–9". */
export const framesOf = ([first, last]) => (first === last ? `${first}` : range(first, last));

function lane(part) {
  return server.lanes?.[part.name];
}

/** A part without motions of its own moves with the one it is a child of. */
function follows({ parent }) {
  const label = partNamed(parent)?.label.toLowerCase();
  return label ? `Moves with the ${label}` : 'Not tracked';
}

function restWord(part) {
  if (part.tracked.length === 0 && !isSurface()) return follows(part);
  const here = server.view.frame;
  const known = (server.segments ?? []).some((one) => reaches(one, here) && isTracked(one));
  if (!known) return `Not ${words().done} yet`;
  return isSurface() ? 'Fitted, not rated' : 'Tracked. Previews are not rated';
}

/** face(part) → {selected, hovered, over(), out(), act()}, as in figure.js. */
export function tree(body, face) {
  const roots = body.parts.filter((part) => !part.parent);
  return html`<div class="tree" role="tree" aria-label="Parts">
    ${roots.flatMap(branch).map((part) => row(part, face(part)))}
  </div>`;
}

/** A part and all below it, in the order they are drawn. */
function branch(part) {
  return [part, ...childrenOf(part).flatMap(branch)];
}

function row(part, look) {
  return html`<button
    type="button"
    role="treeitem"
    class="row ${look.selected ? 'sel' : ''} ${look.hovered ? 'hov' : ''}"
    tabindex=${look.first ? 0 : -1}
    aria-selected=${look.selected}
    title=${part.label}
    @pointerenter=${look.over}
    @pointerleave=${look.out}
    @click=${look.act}
  >
    ${rails(part)}<span class="dot" style="background:var(--${part.side})"></span>
    <span class="cut">${part.short}</span>${part.mirror ? html`<small>${part.side}</small>` : nothing}
  </button>`;
}

/** One line per ancestor that has more children below, and the bend to the part itself. */
function rails(part) {
  if (!part.parent) return nothing;
  const line = [...ancestors(part), part].slice(1);
  return line.map((step, i) => {
    const bend = i === line.length - 1;
    return html`<i class="${bend ? 'bend' : ''} ${isLast(step) ? 'end' : ''}"></i>`;
  });
}

function isLast(part) {
  return childrenOf({ name: part.parent }).at(-1).name === part.name;
}

const RUNS_SHOWN = 2;

export function picker() {
  const part = selectedPart();
  if (part) remember(part);
  const person = isPerson(server.body);
  return html`<div class="pick ${person ? '' : 'listed'}">
    <div class="fig" @keydown=${walk}>${person ? figure(server.body, faceOf) : tree(server.body, faceOf)}</div>
    <div class="stack inf">${part ? about(part) : nothingSelected()}
      <span class="sp"></span>
      <span class="row walk">${part ? steps() : nothing}<span class="sp"></span>${byName()}</span>
    </div>
  </div>`;
}

/** How one part of the figure looks and what it does. */
function faceOf(part) {
  return {
    selected: part.name === server.view.selected,
    first: part.name === (server.view.selected ?? server.body.parts[0].name), // where Tab arrives
    hovered: part.name === ui.figureHover || part.name === ui.hover,
    over: () => setUi('figureHover', part.name),
    out: () => setUi('figureHover', null),
    act: () => select(part.name),
  };
}

/** The keys of a figure that was reached with Tab. */
function walk(event) {
  const moves = {
    ArrowUp: () => alongChain(-1),
    ArrowDown: () => alongChain(1),
    ArrowLeft: otherSide,
    ArrowRight: otherSide,
    Enter: () => event.target.dispatchEvent(new MouseEvent('click')),
  };
  const move = moves[event.key === ' ' ? 'Enter' : event.key];
  if (!move) return;
  event.preventDefault();
  event.stopPropagation();
  move();
}

function about(part) {
  return html`<span class="row dim crumbs">${crumbs(part)}</span>
    <h2 class="row" title=${part.label}>
      <span class="dot" style="background:var(--${part.side})"></span>
      <span class="cut">${part.label}</span>
    </h2>
    <span class="mut" role="status">${seenHere(part)}</span>
    ${hiddenLinks(part)}`;
}

function nothingSelected() {
  const over = partNamed(ui.figureHover);
  return html`<span class="dim crumbs">No part selected</span>
    <span class="mut">${over ? over.label : 'Click a part here or in a view.'}</span>`;
}

/** The two nearest parents; a click goes there. */
function crumbs(part) {
  const line = ancestors(part).slice(-2);
  if (line.length === 0) return html`Root`;
  return line.map(
    (up, i) => html`${i ? icon('chr', 'width:10px') : nothing}<button
        type="button"
        class="crumb"
        title=${`Select ${up.label.toLowerCase()}`}
        @click=${() => select(up.name)}
      >${up.short}</button>`,
  );
}

function hiddenLinks(part) {
  const runs = hiddenRuns(part);
  if (runs.length === 0) return nothing;
  const one = (run, i) => html`${i ? ', ' : ''}<button
      type="button"
      class="crumb"
      title=${`Go to the middle of ${framesOf(run)}`}
      @click=${() => perform('goTo', Math.round((run[0] + run[1]) / 2))}
    >${framesOf(run)}</button>`;
  const more = runs.length - RUNS_SHOWN;
  return html`<span class="dim tall cut">Hidden in ${runs.slice(0, RUNS_SHOWN).map(one)}${
    more > 0 ? `, ${more} more` : ''
  }</span>`;
}

const steps = () => html`${actionIcon('otherSide')}${actionIcon('inward')}${actionIcon('outward')}`;

function byName() {
  return dropdown({
    label: 'Part',
    text: isPerson(server.body) ? 'By name' : 'Find',
    kind: 'ghost',
    search: true,
    title: 'Select a part by name',
    value: server.view.selected,
    options: partOptions(),
    act: select,
  });
}

/** All parts, in the groups the timeline's lanes have. */
function partOptions() {
  const left = new Map(server.body.parts.map((part) => [part.name, part]));
  const options = [];
  const rest = { label: 'Other parts', parts: [...left.keys()] };
  for (const group of [...(server.body.lanes ?? []), rest]) {
    for (const name of group.parts) {
      const part = left.get(name);
      if (!part) continue;
      left.delete(name);
      options.push({ id: name, label: part.label, group: group.label, dot: part.side });
    }
  }
  return options;
}
