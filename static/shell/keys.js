// The keyboard: a chord is looked up in the table of actions; the sheet of keys.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { BY_CHORD, keySheet, perform, spell, WHILE_PLAYING } from '../actions/actions.js';
import { awaitPaste, mountPaste } from '../actions/copying.js';
import { discardReduction, discardSizes, lookBack, onPreviewKey, onReductionKey } from '../actions/proposals.js';
import { closeReview, onReviewKey } from '../actions/review.js';
import { clearSelection } from '../actions/selection.js';
import { closeSheets, mountDialog, toggleSheet } from '../controls/dialogs.js';
import { keepsKey, leaveControl } from '../controls/focus.js';
import { icon } from '../controls/icons.js';
import { closeMenu } from '../controls/menu.js';
import { closeGuide, openGuide } from '../guide/guide.js';
import { bodies } from '../store/bodies.js';
import { server, setUi, ui } from '../store/state.js';
import { closeFit } from './fit_card.js';
import { closeUp } from './up_card.js';
import { cancelJob } from './job.js';

const SYMBOL = /^[^\p{L}\s]$/u;

export function mountKeys() {
  addEventListener('keydown', onKeyDown);
  addEventListener('keyup', onKeyUp);
  mountPaste(() => Boolean(ui.sheet || ui.chooser || ui.dragging) || keepsKey('Ctrl V'));
  addEventListener('pointerdown', () => (space.isUsed = true), true);
  addEventListener('blur', () => {
    setUi('space', false);
    lookBack(false);
  });
  for (const kind of ['pointerup', 'pointercancel']) addEventListener(kind, () => lookBack(false));
}

/** "Ctrl Shift Z": the key with its modifiers; empty when none of ours is meant. */
function chordOf(event) {
  // On many keyboards [ ] and / need AltGr, which some systems report as Ctrl and Alt.
  const graph = event.getModifierState('AltGraph');
  if (event.altKey && !graph) return '';
  const key = nameOf(event);
  const parts = [
    (event.ctrlKey || event.metaKey) && !graph && 'Ctrl',
    // Whether "?" or "1" needs Shift is the keyboard's affair.
    event.shiftKey && !SYMBOL.test(key) && 'Shift',
    key,
  ];
  return parts.filter(Boolean).join(' ');
}

function nameOf({ key, code }) {
  if (key === ' ') return 'Space';
  if (key.length > 1) return key;
  if (/^[a-z]$/i.test(key)) return key.toUpperCase();
  // A letter of another alphabet: the key that bears ours on the keyboard.
  const letter = /\p{L}/u.test(key) && code.match(/^Key([A-Z])$/);
  return letter ? letter[1] : key;
}

function onKeyDown(event) {
  if (event.defaultPrevented || event.isComposing || ui.dragging) return;
  const chord = chordOf(event);
  if (chord === 'Escape') {
    if (escape()) event.preventDefault();
    return;
  }
  if (keepsKey(chord) || hasText(chord) || isModal(chord)) return;
  if (onPreviewKey(chord, event) || onReductionKey(chord, event) || onReviewKey(chord, event)) return;
  if (chord === 'Space') {
    pressSpace(event);
    return;
  }
  if (server.file && (chord === 'Ctrl V' || chord === 'Ctrl Shift V')) {
    awaitPaste(chord === 'Ctrl Shift V'); // the browser goes on to deliver what is on its clipboard
    return;
  }
  if (ui.playing && WHILE_PLAYING.has(chord)) {
    event.preventDefault();
    if (!event.repeat) perform(WHILE_PLAYING.get(chord));
    return;
  }
  if (chord === 'Tab' && !meansBodies()) return;
  const binding = BY_CHORD.get(chord);
  if (!binding || (!server.file && !binding.always)) return;
  event.preventDefault();
  if (!event.repeat || binding.repeats) perform(binding.id);
}

/** Tab goes through the bodies while the keys are with the views, and through the controls else. */
const meansBodies = () => bodies().length > 1 && document.activeElement === document.body;

/** What Esc ends, the nearest first; whether there was anything. */
function escape() {
  return (
    closeSheets() ||
    closeMenu() ||
    leaveControl() ||
    cancelDraft() ||
    discardSizes() ||
    discardReduction() ||
    clearSelection() ||
    closeFit() ||
    closeUp() ||
    closeGuide() ||
    closeReview() ||
    cancelJob()
  );
}

/** The guide stays open while it waits for a draft. */
const cancelDraft = () => server.job?.kind === 'draft' && cancelJob();

/** A text that is marked in a message is what Ctrl C should copy. */
const hasText = (chord) => chord === 'Ctrl C' && !getSelection().isCollapsed;

/** Under an open sheet the page does not change; the key that opened it closes it. */
const isModal = (chord) =>
  chord !== '?' && Boolean(ui.sheet || ui.chooser || ui.search || ui.exporting || ui.importing);

// Space plays when it is released, unless a drag has used it to move the picture.
const space = { isUsed: false };

function pressSpace(event) {
  if (!server.file) return;
  event.preventDefault();
  if (event.repeat || ui.space) return;
  space.isUsed = false;
  setUi('space', true);
}

function onKeyUp(event) {
  if (event.key.toUpperCase() === 'B') lookBack(false);
  if (event.key !== ' ' || !ui.space) return;
  setUi('space', false);
  if (!space.isUsed) perform('play');
}

export function mountSheet() {
  mountDialog({ id: 'keys-sheet', label: 'Keys', name: 'sheet', names: ['file'], draw: dialog });
}

function dialog() {
  return html`<div class="in">
    <div class="row sheethead">
      <span class="title">Keys</span><span class="sp"></span>
      ${
        server.file
          ? html`<button class="btn sm ghost" @click=${showGuide}>Show the first-pose guide</button>`
          : nothing
      }
      <button class="ib" title="Close" data-key="Esc" aria-label="Close" autofocus @click=${toggleSheet}>
        ${icon('x')}
      </button>
    </div>
    <div class="th3">${keySheet().map(group)}</div>
  </div>`;
}

function group({ title, lines }) {
  return html`<div>
    <h3>${title}</h3>
    ${lines.map(
      ({ words, keys }) =>
        html`<div class="row kl"><span>${words}</span>${keys.map((chord) => html`<kbd>${spell(chord)}</kbd>`)}</div>`,
    )}
  </div>`;
}

function showGuide() {
  setUi('sheet', null);
  openGuide();
}
