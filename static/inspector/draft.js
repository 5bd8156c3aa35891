// A first pose for every frame, from a box drawn around the person on one of them.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { labelOf, titleOf, whyNot } from '../actions/actions.js';
import { goTo, placesToConfirm, stopPlaying } from '../actions/playhead.js';
import { reasonOf, smallWords, whyNotDraftable } from '../actions/drafting.js';
import { button } from '../controls/fields.js';
import { icon } from '../controls/icons.js';
import { sizeWords } from '../handles/box.js';
import { draftFromBox } from '../handles/sketch.js';
import { drawingButton, fact, section } from './section.js';

export function draft() {
  const why = whyNotDraftable();
  if (why) return section('Draft', html`<p class="note">${why}. Choose one in the Body tab.</p>`);
  return section(
    'Draft',
    html`<p class="note">Finds the person in every frame and poses the body there. Runs on this computer only.</p>
    ${drawingButton('box', {
      name: 'crop', label: 'Draw a box', busy: 'Drag a box around the person',
      title: 'Show which person: drag a box around them, in any frame that shows the whole body',
    })}
    ${ui.tool === 'box' ? begun() : places()}`,
  );
}

/** Where the draft is unsure, as on the timeline. */
function places() {
  const all = placesToConfirm();
  if (all.length === 0) return nothing;
  return html`<div class="places" role="group" aria-label="Places to confirm">
    <h3>To confirm: correct the pose there, then press K</h3>
    ${all.map((place, i) => html`<button type="button" class="place ${place.frame === server.view.frame ? 'sel' : ''}"
      title=${`${reasonOf(place)}. Go to frame ${place.frame}`} @click=${() => (stopPlaying(), goTo(place.frame))}>
      <i class="num">${i + 1}</i><span class="cut">${reasonOf(place)}</span><span class="num dim">${place.frame}</span>
    </button>`)}
  </div>`;
}

/** While the box is drawn: what it is of, and what comes next. */
function begun() {
  const small = smallWords();
  return html`${fact('Person', ui.box ? `${sizeWords(ui.box)} px` : 'no box yet', 'Width and height of the box')}
    ${small ? html`<p class="note warned">${icon('warn')}<span>${small}</span></p>` : nothing}
    ${button({
      name: 'wand', label: labelOf('draft'), title: titleOf('draft'), key: 'Enter', kind: 'pri full',
      off: whyNot('draft'), act: draftFromBox,
    })}`;
}
