// The second channel beside colour: every verdict has a pattern of its own,
// and so have frames that are damaged in the file.

import { svg } from '../../vendor/lit-html/lit-html.js';

export const PATTERNS = svg`<defs>
  <pattern id="tl-check" width="8" height="8" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="f-check" width="8" height="8" opacity=".38" />
    <rect class="f-check" width="3.5" height="8" />
  </pattern>
  <pattern id="tl-lost" width="7" height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="f-lost" width="7" height="7" opacity=".28" />
    <path class="s-lost" d="M0 0H7M0 0V7" stroke-width="3.4" />
  </pattern>
  <pattern id="tl-track" width="12" height="12" patternUnits="userSpaceOnUse">
    <rect class="f-track" width="12" height="12" />
    <path class="stripes" d="M-12 12 0 0H5L-7 12zM0 12 12 0h5L5 12z" fill="#fff" opacity=".28" />
  </pattern>
  <pattern id="tl-hidden" width="5" height="5" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
    <rect class="f-quiet" width="1.4" height="5" />
  </pattern>
  <pattern id="tl-damaged" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(-45)">
    <rect class="f-damaged" width="1.5" height="6" opacity=".4" />
  </pattern>
</defs>`;

/** A diamond about a point, as path data. */
export function diamond(x, y, r) {
  return `M${x} ${y - r}l${r} ${r}-${r} ${r}-${r}-${r}z`;
}
