// Buttons, boxes to tick, choices and lines of text. A control
// that cannot be used now says why in its tooltip and stays reachable, so that the reason can be read
// (hence aria-disabled, not disabled).

import { html, nothing } from '../vendor/lit-html/lit-html.js';
import { icon } from './icons.js';
import { belowOrAbove, standAt } from './menu.js';

const STAY_MS = 4000;
let bubble = null;
let timer = 0;

/** Shake, unless the person asked for less motion. */
export function shake(element) {
  if (matchMedia('(prefers-reduced-motion: reduce)').matches) return;
  const moves = [0, -2, 2, -2, 2, 0].map((x) => ({ transform: `translateX(${x}px)` }));
  element.animate(moves, { duration: 240 });
}

/** Say one sentence below an element until the next input, or four seconds. */
export function say(element, words) {
  hush();
  bubble ??= createBubble();
  bubble.textContent = words;
  bubble.showPopover();
  place(element);
  timer = setTimeout(hush, STAY_MS);
}

export function hush() {
  clearTimeout(timer);
  if (bubble?.matches(':popover-open')) bubble.hidePopover();
}

function createBubble() {
  const element = document.createElement('div');
  element.className = 'refusal';
  element.popover = 'manual';
  element.setAttribute('role', 'alert');
  document.body.append(element);
  return element;
}

function place(element) {
  const at = element.getBoundingClientRect();
  const own = bubble.getBoundingClientRect();
  standAt(bubble, at.right - own.width, belowOrAbove(own.height, at.bottom + 4, at.top - 4));
}

/**
 * A square button with an icon. off: why it cannot be used, or ''.
 * @param {{ name: string, label: string, title?: string, key?: string, act: () => unknown, off?: string,
 *   pressed?: boolean, size?: 's' | '', action?: string }} spec
 */
export function iconButton({ name, label, title = label, key = '', act, off = '', pressed, size = 's', action }) {
  return html`<button
    type="button"
    class="ib ${size} ${off ? 'off' : ''}"
    data-action=${action ?? nothing}
    title=${off || title}
    data-key=${(!off && key) || nothing}
    aria-label=${label}
    aria-disabled=${off ? 'true' : nothing}
    aria-pressed=${pressed ?? nothing}
    @click=${() => off || act()}
  >
    ${icon(name)}
  </button>`;
}

/**
 * A button with words.
 * @param {{ name?: string, label: string, key?: string, title?: string,
 *   act: () => unknown, off?: string, kind?: string }} spec
 */
export function button({ name, label, key = '', title = label, act, off = '', kind = '' }) {
  return html`<button
    type="button"
    class="btn sm ${kind} ${off ? 'off' : ''}"
    title=${off || title}
    data-key=${(!off && key) || nothing}
    aria-disabled=${off ? 'true' : nothing}
    @click=${() => off || act()}
  >
    ${name ? icon(name) : nothing}<span class="cut">${label}</span>
  </button>`;
}

/** A box to tick. */
export function checkbox({ label, on, act, title = label, key = '', off = '', role = 'checkbox' }) {
  return html`<button
    type="button"
    role=${role}
    class="row cb ${on ? 'on' : ''} ${off ? 'off' : ''}"
    aria-checked=${on}
    aria-disabled=${off ? 'true' : nothing}
    title=${off || title}
    data-key=${(!off && key) || nothing}
    @click=${() => off || act(!on)}
  >
    <i>${on ? icon('check') : nothing}</i>${label}
  </button>`;
}

/**
 * A switch. off: why it cannot be used, or ''; stays: why it cannot be switched off, or '': pressed
 * then, it shakes and says so.
 */
export function switchField({ label, on, act, title = label, off = '', stays = '' }) {
  const why = off || (on ? stays : '');
  const press = ({ currentTarget }) => {
    if (!why) return act(!on);
    if (off) return undefined;
    shake(currentTarget);
    return say(currentTarget, `${why}.`);
  };
  return html`<button
    type="button"
    role="switch"
    class="switch field ${off ? 'off' : ''}"
    aria-checked=${on}
    aria-disabled=${why ? 'true' : nothing}
    title=${why || title}
    @click=${press}
  >
    <i></i>${label}
  </button>`;
}

/** One of a few: options are {id, label, title?, off?}. */
export function segmented({ label, value, options, act, off = '' }) {
  const one = (option) => {
    const reason = off || option.off || '';
    return html`<button
      type="button"
      class=${reason ? 'off' : ''}
      aria-pressed=${option.id === value}
      aria-disabled=${reason ? 'true' : nothing}
      title=${reason || option.title || nothing}
      @click=${() => reason || option.id === value || act(option.id)}
    >
      ${option.label}
    </button>`;
  };
  return html`<div class="seg" role="group" aria-label=${label}>${options.map(one)}</div>`;
}

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
