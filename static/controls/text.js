// A line of text: Enter and Tab take it over, Esc restores.

import { html } from '../vendor/lit-html/lit-html.js';

/** value and act(text); the server's echo does not write into it while it is typed in. */
export function textField({ label, value, placeholder = '', act, most = 200 }) {
  const key = (event) => {
    if (event.key !== 'Enter' && event.key !== 'Escape') return;
    event.stopPropagation();
    if (event.key === 'Escape') event.target.value = value;
    event.target.blur();
  };
  const leave = (event) => {
    const text = event.target.value.trim();
    if (text !== value) act(text);
  };
  // lit-html writes the property only when the server's value is another than before.
  return html`<input
    class="n text"
    .value=${value}
    maxlength=${most}
    placeholder=${placeholder}
    aria-label=${label}
    title=${label}
    @keydown=${key}
    @blur=${leave}
  />`;
}
