// What is not plausible of the motion in space: the worst of it, each with its frame and its remedy.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, setUi, ui } from '../store/state.js';
import { send } from '../store/link.js';
import { select } from '../store/parts.js';
import { labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { actionButton } from '../actions/buttons.js';
import { unpinOver } from '../actions/pins.js';
import { goTo, stopPlaying } from '../actions/playhead.js';
import { button } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { section } from './section.js';

/** @typedef {import('../store/shapes.js').SpaceFinding} SpaceFinding */

const MOST = 3;
const NEAR_CM = 2; // as far as soles that stand are off

/** What mends a finding with one press; nothing where there is no such thing. */
/**
 * @type {Record<string, { label: string | ((found: SpaceFinding) => string), title?: string, act: (found: SpaceFinding) => void }>}
 */
const REMEDIES = {
  pin: {
    label: 'Pin it',
    act: ({ kind, part, first, last }) =>
      send({ do: 'set_pin', part, frame: first, first, last, floor: kind === 'off_floor' }),
  },
  floor: {
    label: 'Set floor',
    act: ({ part, go }) => {
      goTo(go);
      send({ do: 'floor', under: part });
    },
  },
  turn: {
    label: 'Turn in depth',
    act: ({ part, go }) => {
      goTo(go);
      send({ do: 'turn_in_depth', part });
    },
  },
  untwist: {
    label: 'Untwist',
    act: ({ part, go }) => {
      goTo(go);
      send({ do: 'untwist', part });
    },
  },
  unpin: { label: 'Unpin', act: ({ part, first, last }) => unpinOver(part, first, last) },
  soften: {
    label: (found) => labelOf('softKeys', keyframesOf(found)),
    title: titleOf('softKeys'),
    act: (found) => perform('softKeys', keyframesOf(found)),
  },
  level: { label: 'Level the feet', act: () => send({ do: 'up_from_feet' }) },
  lens: { label: 'Set lens', act: () => setUi('tab', 'camera') },
  smooth: { label: 'Smooth', act: () => send({ do: 'settings', smooth: true }) },
};

/** @param {SpaceFinding} found */
const keyframesOf = ({ keyframes, go }) => keyframes ?? [go];

export function space() {
  const found = server.space ?? [];
  if (found.length === 0 && whyNot('stand')) return nothing;
  const shown = ui.allInSpace ? found : found.slice(0, MOST);
  return section(
    'In space',
    html`${soles()}${shown.map(card)}${found.length > MOST ? more(found.length - MOST) : nothing}`,
  );
}

/** How the feet stand, and the press that makes them. */
function soles() {
  const { soles: words, soles_off_cm: off } = server.floor ?? {};
  const isNear = off !== null && Math.abs(off) <= NEAR_CM;
  return html`${
    words
      ? html`<p class=${`note icons ${isNear ? 'good' : 'warned'}`}
    role="status">${icon(isNear ? 'check' : 'warn')}<span>${words}</span></p>`
      : nothing
  }
    ${
      whyNot('stand')
        ? nothing
        : actionButton('stand', undefined, { name: undefined, kind: words ? 'full ghost' : 'full' })
    }`;
}

/** All of them, or the worst alone. @param {number} rest */
function more(rest) {
  const label = ui.allInSpace ? 'Show fewer' : `Show ${rest} more`;
  return button({ name: '', label, kind: 'ghost sm', act: () => setUi('allInSpace', !ui.allInSpace) });
}

/** @param {SpaceFinding} found */
function card(found) {
  const remedy = REMEDIES[found.remedy];
  const label = typeof remedy?.label === 'function' ? remedy.label(found) : remedy?.label;
  return html`<div class="finding" role="group" aria-label=${found.words}>
    <p>${found.words}</p>
    <div class="row">
      ${remedy ? button({ name: '', label, title: remedy.title, kind: 'sm', act: () => remedy.act(found) }) : nothing}
      ${
        ['lens', 'up'].includes(found.kind)
          ? nothing
          : button({ name: '', label: `Go to ${found.go}`, kind: 'ghost sm', act: () => visit(found) })
      }
    </div>
  </div>`;
}

/** @param {SpaceFinding} found */
function visit({ part, go }) {
  stopPlaying();
  select(part);
  goTo(go);
}
