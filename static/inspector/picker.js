// The top of the inspector: the figure, and what is selected.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { perform } from '../actions/actions.js';
import { actionIcon } from '../actions/buttons.js';
import { icon } from '../controls/icons.js';
import { dropdown } from '../controls/fields.js';
import { alongChain, otherSide, remember } from '../actions/chain.js';
import { figure, isPerson } from './figure.js';
import { ancestors, partNamed, select, selectedPart } from '../store/parts.js';
import { framesOf, hiddenRuns, seenHere } from './seen.js';
import { tree } from './tree.js';

const RUNS_SHOWN = 2;

export function picker() {
  const part = selectedPart();
  if (part) remember(part);
  const person = isPerson(server.body);
  return html`<div class="pick ${person ? '' : 'listed'}">
    <div class="fig" @keydown=${walk}>${person ? figure(server.body, face) : tree(server.body, face)}</div>
    <div class="inf">${part ? about(part) : nothingSelected()}
      <span class="sp"></span>
      <span class="row walk">${part ? steps() : nothing}<span class="sp"></span>${byName()}</span>
    </div>
  </div>`;
}

/** How one part of the figure looks and what it does. */
function face(part) {
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
    ArrowUp: () => alongChain(-1), ArrowDown: () => alongChain(1),
    ArrowLeft: otherSide, ArrowRight: otherSide,
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
    label: 'Part', text: isPerson(server.body) ? 'By name' : 'Find', kind: 'ghost', search: true,
    title: 'Select a part by name',
    value: server.view.selected, options: partOptions(), act: select,
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
