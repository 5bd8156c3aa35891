// The keyboard: what is pressed is looked up in the table, wherever the focus is.

import { server, ui, setUi } from '../store/state.js';
import { togglePlaying } from '../timeline/timeline.js';
import { BY_CHORD } from './bindings.js';
import { keepsKey } from '../controls/focus.js';
import { escape } from './escape.js';

const SYMBOL = /^[^\p{L}\s]$/u;

export function mountKeys() {
  addEventListener('keydown', pressed);
  addEventListener('keyup', released);
  addEventListener('pointerdown', () => (held.used = true), true);
  addEventListener('blur', () => setUi('space', false));
}

/** "Ctrl Shift Z": the key with those held beside it; empty when none of ours is meant. */
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

function pressed(event) {
  if (event.defaultPrevented || event.isComposing || ui.dragging) return;
  const chord = chordOf(event);
  if (chord === 'Escape') {
    if (escape()) event.preventDefault();
    return;
  }
  if (keepsKey(chord) || hasText(chord) || isModal(chord)) return;
  if (chord === 'Space') {
    holdSpace(event);
    return;
  }
  const binding = BY_CHORD.get(chord);
  if (!binding || (!server.file && !binding.always)) return;
  event.preventDefault();
  if (!event.repeat || binding.repeats) binding.run();
}

/** A text that is marked in a message is what Ctrl C should copy. */
const hasText = (chord) => chord === 'Ctrl C' && !getSelection().isCollapsed;

/** Under an open sheet the page does not change; the key that opened it closes it. */
const isModal = (chord) => chord !== '?' && Boolean(ui.sheet || ui.chooser);

// Space plays when it is let go, unless a drag has used it to move the picture.
const held = { used: false };

function holdSpace(event) {
  if (!server.file) return;
  event.preventDefault();
  if (event.repeat || ui.space) return;
  held.used = false;
  setUi('space', true);
}

function released(event) {
  if (event.key !== ' ' || !ui.space) return;
  setUi('space', false);
  if (!held.used) togglePlaying();
}
