// The Part tab: the selected part's pose and sizes.

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { pose } from './pose.js';
import { position } from './position.js';
import { rotation } from './rotation.js';
import { size } from './size.js';
import { selectedPart } from './parts.js';

export function partTab() {
  const part = selectedPart();
  if (!part) return html`${pose()}`;
  return html`${part.parent ? nothing : position()}${rotation(part)}${pose()}${size(part)}`;
}
