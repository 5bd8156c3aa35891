// What the selected part holds, or is held by.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { perform } from '../actions/actions.js';
import { actionIcon } from '../actions/buttons.js';
import { bondsOf, otherEnd } from '../actions/bonds.js';
import { goTo } from '../actions/playhead.js';
import { textField } from '../controls/buttons.js';
import { dropdown, segmented } from '../controls/fields.js';
import { range } from '../controls/words.js';
import { bodies, posedBody } from '../store/bodies.js';
import { lastFrame } from '../store/clip.js';
import { send } from '../store/link.js';
import { line, section } from './section.js';

/** @typedef {import('../store/shapes.js').Bond} Bond */

export function bonds(part) {
  const list = bondsOf(part);
  if (bodies().length < 2 && (posedBody()?.parts.length ?? 0) < 2) return nothing;
  return section(
    'Holds',
    html`${list.map((bond) => bondRow(bond, part))}
    ${list.length ? nothing : html`<p class="note">It stays where it holds: a racket in a hand, a hand on a hip.</p>`}`,
    html`${actionIcon('bond')}${choice(part)}`,
  );
}

/** Any part of any body. */
function choice(part) {
  const options = bodies().flatMap(({ id, name, posed, parts }) =>
    parts
      .filter((each) => !posed || each.name !== part.name)
      .map((each) => ({ id: `${id} ${each.name}`, label: each.label, group: posed ? 'This body' : name })),
  );
  return dropdown({
    label: 'Hold',
    text: 'Hold…',
    kind: 'ghost',
    search: true,
    value: null,
    title: 'What it meets from this frame on, as long as both are as near',
    options,
    act(id) {
      const [body, onto] = id.split(' ');
      perform('bond', { body, onto });
    },
  });
}

/** @param {Bond} bond */
function bondRow(bond, part) {
  const { index, first, last, moves, meet } = bond;
  const other = otherEnd(bond, part);
  const change = (fields) => ({ do: 'change_bond', index, ...fields });
  const words = meet ? '' : apartWords(bond);
  return html`<div class="row pinrow">
      <button type="button" class="row name" title=${`Go to frame ${first}`} @click=${() => goTo(first)}>
        <span class="cut">${other.name} · ${other.label}</span>
        <span class="mut num">${range(first, last)}</span></button>
      <span class="sp"></span>${actionIcon('letGo', index)}</div>
    ${line(
      'Frames',
      html`<span class="range">${end('First frame', first, (at) => send(change({ first: at })))}
      <span class="dim">to</span>${end('Last frame', last, (at) => send(change({ last: at })))}</span>`,
    )}
    ${line(
      'Moves',
      segmented({
        label: 'Which of them is moved to the other',
        value: moves,
        options: [
          { id: 'both', label: 'Both' },
          { id: bond.holder === other ? 'held' : 'holder', label: 'This' },
          { id: bond.holder === other ? 'holder' : 'held', label: 'The other' },
        ],
        act: (id) => send(change({ moves: id })),
      }),
    )}
    ${words ? html`<p class="note">${words}.</p>` : nothing}`;
}

/** Why its points do not meet, and what to do. @param {Bond} bond */
export function apartWords({ apart_cm: apart, worst, cause, unposed }) {
  if (cause === 'unposed') return `${unposed} has no keyframe yet: pose it first`;
  const words = `${apart.toFixed(1)} cm apart at frame ${worst}`;
  if (cause === 'keyed') return `${words}, where both are keyed: pose them together there`;
  if (cause === 'tracked') return `${words}, held apart by their keyframes: pose them together there`;
  return `${words} until it is tracked`;
}

const end = (label, value, act) =>
  textField({
    label,
    value: String(value),
    most: 8,
    act: (text) => act(/^\d+$/.test(text) ? Math.min(Number(text), lastFrame()) : value),
  });
