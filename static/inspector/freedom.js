// Which motions the tracker estimates; the others stay as the keyframes around have them.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { iconButton } from '../controls/fields.js';
import { partName, section } from './section.js';
import { selectedPart } from '../store/parts.js';

const TURNS = ['rx', 'ry', 'rz'];
const MOVES = ['tx', 'ty', 'tz'];
const MOVE_WORDS = { tx: 'Across', ty: 'Down', tz: 'Depth' };

export function freedom() {
  const part = selectedPart();
  const all = ui.allFreedoms === true;
  const parts = all ? server.body.parts : part ? [part] : [];
  return section(
    'Tracked motions',
    html`${parts.map((one) => freedoms(one, !all))}
      ${parts.length ? nothing : html`<p class="note">Select a part to choose its tracked motions.</p>`}
      <p class="note">Whole body: ${server.body.dof_count} of ${server.body.dof_total}</p>`,
    iconButton({
      name: 'more', label: all ? 'The selected part only' : 'All parts', pressed: all,
      act: () => setUi('allFreedoms', !all),
    }),
  );
}

function freedoms(part, wordy) {
  return html`<div class="free ${part.name === server.view.selected && !wordy ? 'sel' : ''}">
      ${partName(part)}${toggles(part, TURNS, wordy)}
    </div>
    ${part.parent ? nothing : place(part, wordy)}`;
}

/** Only the root may move as well as turn. */
function place(part, wordy) {
  return html`<div class="free"><span class="mut indent">Position</span>${toggles(part, MOVES, wordy)}</div>`;
}

function toggles(part, dofs, wordy) {
  return html`<div class="seg" role="group" aria-label=${`Motions of ${part.label}`}>
    ${dofs.map((dof) => motion(part, dof, wordy))}
  </div>`;
}

function motion(part, dof, wordy) {
  const axis = dof[1];
  const on = part.tracked.includes(dof);
  const word = MOVE_WORDS[dof] ?? part.words?.[axis] ?? axis.toUpperCase();
  const next = [...MOVES, ...TURNS].filter((each) => (each === dof ? !on : part.tracked.includes(each)));
  const title = on ? `${word} is tracked. Click to keep it as posed` : `${word} stays as posed. Click to track it`;
  return html`<button
    type="button"
    aria-pressed=${on}
    title=${title}
    @click=${() => send({ do: 'tracked', part: part.name, dofs: next })}
  >
    <b style="color:var(--g${axis})">${axis.toUpperCase()}</b>${wordy && on ? html`<span>${word}</span>` : nothing}
  </button>`;
}
