// New sizes that are only shown so far: applied, discarded, compared with what was before.

import { send } from '../store/link.js';
import { server, ui } from '../store/state.js';

let isPressed = false; // whether a button or a key is held, here

export const isPreview = () => Boolean(server.sizes_preview);

export const applySizes = () => send({ do: 'apply_sizes' });

/** Returns whether there was anything to discard. */
export function discardSizes() {
  if (!isPreview()) return false;
  lookBack(false);
  send({ do: 'discard_sizes' });
  return true;
}

/** The body as it is, as long as something is held. */
export function lookBack(on) {
  if (isPressed === on) return;
  isPressed = on;
  if (!on || isPreview()) send({ do: 'look_before', on });
}

/** Enter and B, while new sizes are shown. */
export function onPreviewKey(chord, event) {
  if (!isPreview() || ui.sheet || ui.chooser || (chord !== 'Enter' && chord !== 'B')) return false;
  event.preventDefault();
  if (event.repeat) return true;
  if (chord === 'Enter') applySizes();
  else lookBack(true);
  return true;
}

/** How many segments have to be tracked again, as a sentence. */
export function outdatedWords() {
  const { outdated } = server.sizes_preview;
  if (!outdated) return '';
  return `Apply makes ${outdated} ${outdated === 1 ? 'segment' : 'segments'} outdated.`;
}
