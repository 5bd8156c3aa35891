// Which view stands in the large place: one of the four, or all four equally large.

import { ui, setUi } from '../store/state.js';
import { VIEWS, view } from '../views/views.js';

let before = 'main';

/** Put this view in the large place, or "quad"; the same again goes back to what was before. */
export function showLarge(name) {
  const now = ui.layout;
  if (now === name) {
    setUi('layout', before);
    before = name;
    return;
  }
  before = now;
  setUi('layout', name);
}

/** Fit the picture of what is large. */
export function fitLarge() {
  const names = ui.layout === 'quad' ? VIEWS : [ui.layout];
  for (const name of names) view(name)?.fit();
}
