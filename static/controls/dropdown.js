// A choice from a list that opens below its button, with a search line where the list is long.
//
// spec: { label, value, text (what the button says), kind: 'field' or 'ghost', search: true,
//         options: [{id, label, group?, dot?, note?, off?}], act(id), title, off }

import { html, nothing, render } from '../vendor/lit-html/lit-html.js';
import { icon } from './icons.js';
import { standAt } from './menu.js';

/** The last of these middles of rows that has room, px; the room itself where none has. */
export const middleWithin = (middles, room) => middles.findLast((middle) => middle <= room) ?? room;

class DropDown extends HTMLElement {
  static count = 0;
  popId = '';

  connectedCallback() {
    this.popId ||= `drop-${++DropDown.count}`;
    this.addEventListener('toggle', (event) => this.onToggle(event), { capture: true });
    this.draw();
  }

  set spec(spec) {
    this.known = spec;
    if (this.popId) this.draw();
  }

  get options() {
    const words = (this.filter ?? '').toLowerCase().split(/\s+/).filter(Boolean);
    const fits = (option) => words.every((word) => option.label.toLowerCase().includes(word));
    return this.known.options.filter(fits);
  }

  /** @returns {HTMLElement} */
  get list() {
    return this.found('.drop-list');
  }

  /** @returns {HTMLElement} */
  get button() {
    return this.found('button');
  }

  /**
   * An element that `draw` has drawn.
   * @returns {HTMLElement}
   */
  found(selector) {
    const found = this.querySelector(selector);
    if (!(found instanceof HTMLElement)) throw new Error(`A dropdown without its ${selector}`);
    return found;
  }

  draw() {
    const { kind = 'field', text, label, title = label, off = '', value } = this.known;
    const shown = text ?? this.known.options.find((option) => option.id === value)?.label ?? '';
    render(
      html`<button
          type="button"
          class="${kind === 'field' ? 'drop' : 'btn ghost sm'} ${off ? 'off' : ''}"
          title=${off || title}
          aria-label=${`${label}: ${shown}`}
          aria-haspopup="listbox"
          aria-expanded=${this.isOpen === true}
          aria-disabled=${off ? 'true' : nothing}
          @click=${() => off || this.open()}
          @keydown=${(event) => this.opener(event)}
        >
          <span class="cut">${shown}</span>${icon('chev')}
        </button>
        <div class="menu drop-list" id=${this.popId} popover="auto" @keydown=${(e) => this.key(e)}>
          ${this.isOpen ? this.choices() : nothing}
        </div>`,
      this,
    );
  }

  choices() {
    const options = this.options;
    return html`${this.known.search ? this.search() : nothing}
      <div class="opts" role="listbox" aria-label=${this.known.label} tabindex="-1">
        ${options.map((option, i) => this.choice(option, options[i - 1], i))}
        ${options.length ? nothing : html`<div class="mh">No part has that name.</div>`}
      </div>`;
  }

  search() {
    return html`<input
      class="n text find"
      placeholder="Search"
      aria-label="Search"
      .value=${this.filter ?? ''}
      @input=${(event) => this.look(event.target.value)}
    />`;
  }

  choice(option, before, i) {
    const heading = option.group && option.group !== before?.group;
    return html`${heading ? html`<div class="mh">${option.group}</div>` : nothing}
      <div
        class="row mi ${i === this.at ? 'hov' : ''} ${option.off ? 'off' : ''}"
        role="option"
        aria-selected=${option.id === this.known.value}
        title=${option.off || nothing}
        @pointermove=${() => this.point(i)}
        @click=${() => this.choose(option)}
      >
        ${option.dot ? html`<span class="dot" style="background:var(--${option.dot})"></span>` : nothing}
        <span>${option.label}</span>
        <span class="r">${option.id === this.known.value ? icon('check') : (option.note ?? '')}</span>
      </div>`;
  }

  open() {
    if (this.isOpen) return;
    this.isOpen = true;
    this.filter = '';
    this.at = Math.max(
      0,
      this.options.findIndex((option) => option.id === this.known.value),
    );
    this.draw();
    this.list.showPopover();
    this.place();
    this.found(this.known.search ? '.find' : '.opts').focus();
    this.list.querySelector('.hov')?.scrollIntoView({ block: 'nearest' });
  }

  place() {
    const at = this.button.getBoundingClientRect();
    const style = this.list.style;
    style.minWidth = `${Math.max(at.width, this.known.search ? 200 : 120)}px`;
    style.maxHeight = '';
    const own = this.list.getBoundingClientRect();
    const below = innerHeight - at.bottom - 12;
    const up = own.height > below && at.top > below;
    const room = Math.min(420, up ? at.top - 12 : below);
    const tall = Math.min(own.height, room);
    standAt(this.list, at.left, up ? at.top - tall - 4 : at.bottom + 4);
    style.maxHeight = `${own.height > room ? this.endInRow(room) : room}px`;
  }

  /** A list that goes on ends in the middle of a row, which shows that it does. */
  endInRow(room) {
    const { top, bottom } = this.list.getBoundingClientRect();
    const border = bottom - this.found('.opts').getBoundingClientRect().bottom;
    const rows = [...this.list.querySelectorAll('.mi')].map((row) => row.getBoundingClientRect());
    return middleWithin(
      rows.map((row) => row.top - top + row.height / 2 + border),
      room,
    );
  }

  onToggle(event) {
    if (event.newState !== 'closed') return;
    const { activeElement: focused } = document;
    const inside = focused instanceof HTMLElement && this.list.contains(focused);
    this.isOpen = false;
    // With the keyboard the focus goes back to the button; the mouse leaves it with the views.
    if (inside) focused.blur();
    if (inside && this.byKeyboard) this.button.focus();
    this.byKeyboard = false;
    this.draw();
  }

  choose(option) {
    if (option.off) return;
    this.list.hidePopover();
    if (option.id !== this.known.value) this.known.act(option.id);
  }

  point(i) {
    if (this.at === i) return;
    this.at = i;
    this.draw();
  }

  look(text) {
    this.filter = text;
    this.at = 0;
    this.draw();
  }

  opener(event) {
    if (!['Enter', ' ', 'ArrowDown', 'ArrowUp'].includes(event.key)) return;
    event.preventDefault();
    event.stopPropagation();
    this.byKeyboard = true;
    if (!this.known.off) this.open();
  }

  key(event) {
    event.stopPropagation();
    const move = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const options = this.options;
    if (move !== undefined && options.length) {
      event.preventDefault();
      this.at = (this.at + move + options.length) % options.length;
      this.draw();
      this.list.querySelector('.hov')?.scrollIntoView({ block: 'nearest' });
    }
    if (event.key === 'Tab' || event.key === 'Escape') {
      event.preventDefault();
      this.list.hidePopover();
    }
    if (event.key === 'Enter' && options[this.at]) {
      event.preventDefault();
      this.choose(options[this.at]);
    }
  }
}

customElements.define('drop-down', DropDown);

/** A choice from a list; see above for what `spec` holds. */
export function dropdown(spec) {
  return html`<drop-down .spec=${spec}></drop-down>`;
}
