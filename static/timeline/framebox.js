// The frame as a number to type over: Enter goes there, Esc takes back, +5 and -5 go relatively.

import { html } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { lastFrame } from './draw/scale.js';
import { frame, goTo, hold } from './edit/head.js';

export function frameBox() {
  const digits = String(lastFrame()).length;
  return html`<label class="fbox" title="Type a frame, or +5 and -5">
    ${icon('film', 'width:14px;color:var(--t3)')}
    <input aria-label="Frame" inputmode="numeric" autocomplete="off" spellcheck="false"
      style=${`width:${Math.max(2, digits)}ch`} @focus=${(event) => event.target.select()}
      @keydown=${typed} @blur=${(event) => show(event.target)} />
    <span class="dim">/ ${lastFrame()}</span></label>`;
}

/** Write the playhead's frame into the box; never while someone types in it. */
export function show(input) {
  if (input === null || document.activeElement === input) return;
  input.value = String(frame());
}

function typed(event) {
  const input = event.target;
  event.stopPropagation();
  if (event.key === 'Escape') {
    input.blur();
  } else if (event.key === 'Enter') {
    const to = meant(input.value.trim());
    hold();
    if (to !== null) goTo(to);
    input.blur();
  } else if (event.key === 'ArrowUp' || event.key === 'ArrowDown') {
    event.preventDefault();
    goTo(frame() + (event.key === 'ArrowUp' ? 1 : -1));
    input.value = String(frame());
    input.select();
  }
}

function meant(text) {
  if (!/^[+\-−]?\d+$/.test(text)) return null;
  const number = Number(text.replace('−', '-'));
  return /^\d/.test(text) ? number : frame() + number;
}
