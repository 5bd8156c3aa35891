// Which view stands in the large place: one of the four, or all four equally large.

import { U, put } from '../store/state.js';
import { VIEWS, view } from '../views/views.js';

let before = 'main';

/** Put this view in the large place, or "quad"; the same again goes back to what was before. */
export function showLarge(name) {
  const now = U.layout;
  if (now === name) {
    put('layout', before);
    before = name;
    return;
  }
  before = now;
  put('layout', name);
}

/** Fit the picture of what is large. */
export function fitLarge() {
  const names = U.layout === 'quad' ? VIEWS : [U.layout];
  for (const name of names) view(name)?.fit();
}
