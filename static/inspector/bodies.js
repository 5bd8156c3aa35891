// Which bodies there are: a chip each above the picker, as soon as there are two.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { perform, titleOf } from '../actions/actions.js';
import { nameBody, posedWords } from '../actions/bodies.js';
import { bodyEntries } from '../actions/context_menus.js';
import { actionButton } from '../actions/buttons.js';
import { dropdown } from '../controls/fields.js';
import { openMenuAt } from '../controls/menu.js';
import { bodies } from '../store/bodies.js';
import { send } from '../store/link.js';
import { server, ui } from '../store/state.js';

/** @typedef {import('../store/shapes.js').BodyOfScene} BodyOfScene */

/** What the bodies of the shelf are listed under. */
export const SHELVES = { adult: 'People', child: 'People', animal: 'Animals', object: 'Objects' };

export function bodyChips() {
  if (bodies().length < 2) return nothing;
  return html`<div class="bodies row" role="group" aria-label="Bodies">
    <div class="row own">${bodies().map((body) => (ui.bodyNaming === body.id ? naming(body) : chip(body)))}</div>
    ${addBody('ghost')}
  </div>`;
}

/** A choice of what to add. @param {'field' | 'ghost'} kind */
export const addBody = (kind) =>
  dropdown({
    label: 'Add a body',
    text: '+',
    kind,
    value: null,
    title: titleOf('addBody'),
    options: server.body.presets.map(({ name, label, kind: shelf }) => ({ id: name, label, group: SHELVES[shelf] })),
    act: (id) => perform('addBody', id),
  });

/** Where there is one body only, this is in its section. */
export const firstOfMore = () => (bodies().length < 2 ? actionButton('addBody') : nothing);

/** @param {BodyOfScene} body */
function chip(body) {
  const { id, name, posed, colour, worst } = body;
  const pose = () => (posed ? undefined : send({ do: 'pose_body', body: id }));
  return html`<button
    type="button"
    class="chip onebody ${posed ? 'on' : ''}"
    aria-pressed=${posed}
    title=${`${name}: ${posedWords(body)}${worst ? `, at worst ${worst}` : ''}`}
    @click=${pose}
    @dblclick=${() => perform('nameBody', id)}
    @contextmenu=${(event) => openEntries(event, id)}
  >
    <span class="dot" style="background:${colour}"></span><span class="cut">${name}</span>${
      worst ? html`<i class="worst ${worst}"></i>` : nothing
    }
  </button>`;
}

function openEntries(event, id) {
  event.preventDefault();
  openMenuAt('Body', bodyEntries(id), [event.clientX, event.clientY]);
}

/** @param {BodyOfScene} body */
function naming({ id, name, called }) {
  const end = ({ target }) => nameBody(id, target.value);
  const onKey = (event) => {
    if (event.key === 'Enter') end(event);
    if (event.key === 'Escape') nameBody(id, called);
    event.stopPropagation();
  };
  return html`<input class="naming" maxlength="60" aria-label="Name of the body" .value=${called || name}
    @keydown=${onKey} @blur=${end} />`;
}
