// The line under a job, which grows with it.

import { html, nothing } from '../vendor/lit-html/lit-html.js';

/**
 * Draws how far a job is; it holds no button, for what a progress bar holds is not read out.
 * @param {string} label
 * @param {number | null} percent null where it is not known
 * @param {string} words
 */
export function progressBar(label, percent, words) {
  return html`<span
    class="bar ${percent === null ? 'sweep' : ''}"
    style="width:${percent ?? 30}%"
    role="progressbar"
    aria-label=${label}
    aria-valuenow=${percent === null ? nothing : Math.round(percent)}
    aria-valuetext=${words.trim() || nothing}
  ></span>`;
}
