// Regions of the picture that the tracker leaves out, each over a range of frames.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui, setUi } from '../store/state.js';
import { send } from '../store/link.js';
import { iconButton, numberField, textField } from '../controls/fields.js';
import { drawingButton, section } from './section.js';

export function masks() {
  const list = server.masks ?? [];
  return section(
    'Ignore masks',
    html`${list.map(mask)}${list.length ? nothing : html`<p class="note">
        Cover what moves but is not the body: a passer-by, a screen, a shadow.
      </p>`}
    ${drawingButton('mask', {
      name: 'plus', label: 'Draw a mask in the image', busy: 'Click the corners, then press Enter',
      title: 'Cover what moves but is not the body: click around it',
    })}`,
  );
}

function mask(one, index) {
  const here = one.first <= server.view.frame && server.view.frame <= one.last;
  const change = (fields) => ({ do: 'change_mask', index, ...fields });
  return html`<div
    class="mask ${here ? 'here' : ''} ${index === ui.mask ? 'sel' : ''}"
    title=${here ? 'Holds at this frame' : `Does not hold at frame ${server.view.frame}`}
  >
    <button
      type="button"
      class="lk num"
      aria-label=${`Choose mask ${index + 1}`}
      aria-pressed=${index === ui.mask}
      title="Edit its corners in the image"
      @click=${() => choose(one, index, here)}
    >
      ${index + 1}
    </button>
    ${textField({
      label: `Note on mask ${index + 1}`, value: one.note, placeholder: 'Note',
      act: (note) => send(change({ note })),
    })}
    ${numberField(end(index, 'first', one.first, 0, one.last, change))}<span class="dim">–</span>
    ${numberField(end(index, 'last', one.last, one.first, server.file.frames - 1, change))}
    ${iconButton({
      name: 'trash', label: `Delete mask ${index + 1}`, act: () => send({ do: 'delete_mask', index }),
    })}
  </div>`;
}

/** A chosen mask shows its corners, which it can only where it holds. */
function choose(one, index, here) {
  setUi('mask', index === ui.mask ? null : index);
  if (!here) send({ do: 'go', frame: one.first });
}

function end(index, side, value, min, max, change) {
  const label = side === 'first' ? 'First frame' : 'Last frame';
  return {
    key: `mask.${index}.${side}`, label, value, min, max, decimals: 0, step: 1, coarse: 10,
    edit: (frame) => change({ [side]: Math.round(frame) }),
  };
}
