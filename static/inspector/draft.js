// A first pose for every frame, from a box drawn around the person on one of them.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { labelOf, perform, titleOf, whyNot } from '../actions/actions.js';
import { goTo, placesToConfirm, stopPlaying } from '../actions/playhead.js';
import {
  boxFrameFor,
  draftCount,
  draftRange,
  draftTimeWords,
  nobodyWords,
  reasonOf,
  restCount,
  setDraftRange,
  smallWords,
  whom,
  whyNotDraftable,
} from '../actions/drafting.js';
import { button } from '../controls/fields.js';
import { textField } from '../controls/buttons.js';
import { icon } from '../controls/icons.js';
import { peopleHere } from '../actions/people.js';
import { draftEverybody, draftFromBox, drawBoxAt, sizeWords } from '../handles/box.js';
import { drawingButton, fact, line, section } from './section.js';

export function draft() {
  const why = whyNotDraftable();
  if (why) {
    const remedy = server.body?.is_animals ? '.' : '. Choose one in the Body tab.';
    return section('Draft', html`<p class="note">${why}${remedy}</p>`);
  }
  return section(
    'Draft',
    html`<p class="note">Finds ${whom()} in every frame and poses the body there. Runs on this computer only.</p>
    ${line('Frames', frames())}
    ${drawingButton('box', {
      name: 'crop',
      label: 'Draw a box',
      busy: `Drag a box around ${whom()}`,
      title: `Show where ${whom()} is: drag a box around them, in any frame that shows the whole body`,
    })}
    ${ui.tool === 'box' ? begun() : html`${rest()}${nobody()}${places()}`}`,
  );
}

/** The first and the last frame to draft. */
function frames() {
  const [first, last] = draftRange();
  const field = (label, value, act) =>
    textField({
      label,
      value: String(value),
      most: 8,
      act: (text) => (/^\d+$/.test(text) ? act(Number(text)) : act(value)),
    });
  return html`<span class="range">
    ${field('First frame to draft', first, (at) => setDraftRange(at, last))}
    <span class="dim">to</span>
    ${field('Last frame to draft', last, (at) => setDraftRange(first, at))}
  </span>`;
}

/** What a cancelled draft has left, to go on with. */
function rest() {
  if (!restCount()) return nothing;
  return html`${button({
    name: 'wand',
    label: labelOf('draftRest'),
    title: titleOf('draftRest'),
    kind: 'full',
    off: whyNot('draftRest'),
    act: () => perform('draftRest'),
  })}${time(restCount())}`;
}

const time = (many) => {
  const words = draftTimeWords(many);
  return words ? html`<p class="note">${words}</p>` : nothing;
};

/** Where nobody was found, and what to do about it. */
function nobody() {
  const words = nobodyWords();
  if (!words) return nothing;
  const at = boxFrameFor(server.draft);
  return html`<p class="note warned">${icon('warn')}<span>${words}</span></p>
    ${button({
      name: 'crop',
      label: `Draw a box at ${at}`,
      title: 'Draft these frames from a box in one of them',
      kind: 'full',
      act: () => drawBoxAt(at),
    })}`;
}

/** Where the draft is unsure, as on the timeline. */
function places() {
  const all = placesToConfirm();
  if (all.length === 0) return nothing;
  return html`<div class="places" role="group" aria-label="Places to confirm">
    <h3 aria-level="2">To confirm: correct the pose there, then press K</h3>
    ${all.map(
      (place, i) => html`<button type="button" class="listrow place ${place.frame === server.view.frame ? 'sel' : ''}"
      title=${`${reasonOf(place)}. Go to frame ${place.frame}`} @click=${() => (stopPlaying(), goTo(place.frame))}>
      <i class="num">${i + 1}</i><span class="cut">${reasonOf(place)}</span><span class="num dim">${place.frame}</span>
    </button>`,
    )}
  </div>`;
}

/** While the box is drawn: what it is of, and what comes next. */
function begun() {
  const small = smallWords();
  const label = server.body?.is_animals ? 'Animal' : 'Person';
  return html`${fact(label, ui.box ? `${sizeWords(ui.box)} px` : 'no box yet', 'Width and height of the box')}
    ${small ? html`<p class="note warned">${icon('warn')}<span>${small}</span></p>` : nothing}
    ${button({
      name: 'wand',
      label: labelOf('draft'),
      title: titleOf('draft'),
      key: 'Enter',
      kind: 'pri full',
      off: whyNot('draft'),
      act: draftFromBox,
    })}${everybody()}${time(draftCount())}`;
}

/** Where several people were found, all of them at once. */
export function everybody() {
  const { length } = peopleHere();
  if (length < 2) return nothing;
  return button({
    name: 'person',
    label: labelOf('draftAll'),
    title: titleOf('draftAll'),
    kind: 'full',
    off: whyNot('draftAll'),
    act: draftEverybody,
  });
}
