// The card that a note is written on, over its frame. What was written is kept when the card closes,
// unless with Esc.

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { labelOf, perform } from '../actions/actions.js';
import { isWriting, LONGEST, noteAt, noteMessage } from '../actions/keying.js';
import { lastFrame } from '../store/clip.js';
import { send } from '../store/link.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { icon } from '../controls/icons.js';
import { standAt } from '../controls/menu.js';
import { GUTTER, right, x } from './draw/scale.js';

const ABOVE_PX = 6;
/** Letters from which on it is said how many are left. */
const NEARLY_FULL = 400;

let place = null;
let drawing = null;
/** The frame that is written about, its words as they were, and what had the focus before. */
let open = null;

/** Draw the card in this element, over the timeline's drawing. */
export function mountNoteCard(element, timeline) {
  [place, drawing] = [element, timeline];
  addEventListener(
    'pointerdown',
    (event) => {
      if (open && !place.contains(/** @type {Node} */ (event.target))) close(true);
    },
    true,
  );
  watch(['u:note', 'u:search', 'file'], follow);
}

function follow() {
  if (open && ui.search) close(true);
  if (open && (ui.note !== open.frame || server.file?.path !== open.path)) close(server.file?.path === open.path);
  if (!isWriting() || open || !server.file) return;
  const text = noteAt(ui.note)?.text ?? '';
  open = { frame: ui.note, path: server.file.path, isNew: !noteAt(ui.note), before: document.activeElement };
  draw(text);
  put();
  const input = place.querySelector('textarea');
  input.value = text;
  input.focus({ preventScroll: true });
  input.setSelectionRange(text.length, text.length);
}

function draw(text) {
  const left = LONGEST - text.length;
  render(
    html`<div class="menu stack notecard" role="dialog" aria-label=${`Note at frame ${open.frame}`} data-keeps-focus
      @keydown=${onKey}>
    <div class="row"><span class="i14">${icon('note')}</span><b>Note at frame ${open.frame}</b><span class="sp"></span>
      <span class="dim num" aria-live="polite">${left <= LONGEST - NEARLY_FULL ? `${left} left` : nothing}</span></div>
    <textarea rows="3" maxlength=${LONGEST} aria-label="Note" placeholder="Left empty, it is a flag"
      @input=${(event) => draw(event.target.value)}></textarea>
    <div class="row">${
      open.isNew
        ? nothing
        : html`<button class="btn sm ghost" title=${labelOf('deleteNote')}
      @click=${remove}>${icon('trash')}Delete</button>`
    }
      <span class="sp"></span>
      <button class="btn sm ghost" @click=${() => close(false)}>Cancel<kbd>Esc</kbd></button>
      <button class="btn sm pri" @click=${() => close(true)}>Save<kbd>Enter</kbd></button></div>
  </div>`,
    place,
  );
}

/** Over its frame, as far as that is shown. */
function put() {
  const card = place.firstElementChild;
  const box = drawing.getBoundingClientRect();
  const { width, height } = card.getBoundingClientRect();
  const at = Math.min(right(), Math.max(GUTTER, lastFrame() > 0 ? x(open.frame) : GUTTER));
  standAt(card, box.left + at - width / 2, Math.max(ABOVE_PX, box.top - height - ABOVE_PX));
}

function onKey(event) {
  event.stopPropagation();
  const { key, shiftKey, isComposing, target } = event;
  const isAnswer = key === 'Enter' && !shiftKey && !isComposing && target.matches('textarea');
  if (key !== 'Escape' && !isAnswer) return;
  event.preventDefault();
  close(isAnswer);
}

function remove() {
  const at = open.frame;
  close(false);
  perform('deleteNote', at);
}

function close(keeps) {
  const { frame: at, before } = open;
  const message = keeps ? noteMessage(at, place.querySelector('textarea').value) : null;
  open = null;
  render(nothing, place);
  setUi('note', null);
  if (message) send(message);
  if (before instanceof HTMLElement && before !== document.body) before.focus({ preventScroll: true });
}
