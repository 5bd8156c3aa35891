// A slider: thin line the range, thick band the limits, tick the rest pose, fill from the tick.
//
// spec as in value.js, and: zero (where the fill begins and the tick stands), tick: false to hide
// it, band (limits that are drawn though they may not hold), log (each part of the line is a ratio),
// rolls (the wheel turns it without the focus, too).

import { html } from '../vendor/lit-html/lit-html.js';
import { clamp, shortNumber } from './arithmetic.js';
import { followValue, ValueElement } from './value.js';

const GRAB_PX = 9;

const bar = (className) => Object.assign(document.createElement('span'), { className });

class SlideBar extends ValueElement {
  bars = { lim: bar('lim'), zero: bar('zero'), fill: bar('fill'), th: bar('th') };

  build() {
    this.classList.add('rng');
    this.setAttribute('role', 'slider');
    this.append(...Object.values(this.bars));
    this.addEventListener('mousedown', (event) => this.keepFocusAway(event));
    this.addEventListener('pointerdown', (event) => this.press(event));
    this.addEventListener('dblclick', () => this.toRest());
    this.addEventListener('keydown', (event) => this.key(event));
    this.addEventListener('wheel', (event) => this.roll(event), { passive: false });
  }

  draw() {
    const { limit, band = limit, zero = this.spec.min, off = '', label, unit = '', min, max } = this.spec;
    const at = this.share(this.value ?? zero);
    const rest = this.share(zero);
    this.classList.toggle('on', this.isDragged === true);
    this.classList.toggle('off', off !== '');
    this.tabIndex = off ? -1 : 0;
    this.title = off || this.spec.title || label;
    span(this.bars.lim, band ? this.share(band[0]) : 0, band ? this.share(band[1]) : 0);
    span(this.bars.fill, Math.min(at, rest), off ? Math.min(at, rest) : Math.max(at, rest));
    this.bars.zero.hidden = this.spec.tick === false;
    this.bars.zero.style.left = `${rest}%`;
    this.bars.th.style.left = `${at}%`;
    this.setAttribute('aria-label', label);
    this.setAttribute('aria-valuemin', limit?.[0] ?? min);
    this.setAttribute('aria-valuemax', limit?.[1] ?? max);
    this.setAttribute('aria-valuenow', this.value ?? zero);
    this.setAttribute('aria-valuetext', `${shortNumber(this.value ?? zero, this.spec.decimals ?? 1)} ${unit}`);
    this.setAttribute('aria-disabled', String(off !== ''));
  }

  /** Both ends; they stay where they are while the thumb is dragged, whatever the server says. */
  get ends() {
    return this.fixed ?? [this.spec.min, this.spec.max];
  }

  /** Where a value stands, in percent of the line. */
  share(value) {
    const [min, max] = this.ends.map(this.onLine);
    return 100 * clamp((this.onLine(value) - min) / (max - min), 0, 1);
  }

  /** A value as a length along the line, and back. */
  onLine = (value) => (this.spec.log ? Math.log(value) : value);
  offLine = (length) => (this.spec.log ? Math.exp(length) : length);

  /** The mouse never takes the keys away from the frame. */
  keepFocusAway(event) {
    if (event.button !== 0) return;
    event.preventDefault();
    document.activeElement?.blur();
  }

  press(event) {
    if (event.button !== 0 || this.spec.off) return;
    const box = this.getBoundingClientRect();
    const thumb = box.left + (this.share(this.value) / 100) * box.width;
    this.fixed = this.ends;
    const [min, max] = this.fixed.map(this.onLine);
    const perPixel = (max - min) / box.width;
    // A press on the thumb moves nothing yet; a press beside it brings the thumb there.
    const grabbed = Math.abs(event.clientX - thumb) <= GRAB_PX;
    const there = min + (event.clientX - box.left) * perPixel;
    const from = { x: event.clientX, value: grabbed ? this.onLine(this.value) : there, perPixel };
    this.isDragged = true;
    if (grabbed) this.draw();
    else this.moveTo(this.offLine(there));
    followValue(this, event, {
      move: (now) => this.drag(from, now),
      end: () => this.release(),
      cancel: () => this.drop(),
    });
  }

  drag(from, event) {
    from.value += (event.clientX - from.x) * from.perPixel * (event.shiftKey ? 0.1 : 1);
    from.x = event.clientX;
    const coarse = this.spec.coarse ?? this.steps * 5;
    const value = this.offLine(from.value);
    this.moveTo(event.ctrlKey ? Math.round(value / coarse) * coarse : value);
  }

  release() {
    this.isDragged = false;
    this.fixed = null;
    this.finish();
    this.draw();
  }

  drop() {
    this.isDragged = false;
    this.fixed = null;
    this.cancelStroke();
    this.draw();
  }

  toRest() {
    if (this.spec.tick !== false && !this.spec.off) this.setTo(this.spec.zero ?? this.spec.min);
  }

  key(event) {
    const ways = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 };
    const way = ways[event.key];
    const ends = { Home: this.spec.limit?.[0] ?? this.spec.min, End: this.spec.limit?.[1] ?? this.spec.max };
    if (way === undefined && !(event.key in ends) && event.key !== 'Escape') return;
    event.preventDefault();
    event.stopPropagation();
    if (event.key === 'Escape') this.escape();
    else if (way !== undefined) this.nudge(way * this.stride(event));
    else this.setTo(ends[event.key]);
  }

  /** Cancels a run of nudges; where there is none, the keys go back to the frame. */
  escape() {
    if (!this.cancelStroke()) this.blur();
  }

  roll(event) {
    if (document.activeElement !== this && !this.spec.rolls) return;
    event.preventDefault();
    const notches = this.notches(event);
    if (notches !== 0) this.nudge(notches * this.stride(event));
  }
}

function span(element, from, to) {
  element.style.left = `${from}%`;
  element.style.width = `${Math.max(0, to - from)}%`;
}

customElements.define('slide-bar', SlideBar);

/** A slider; see above for what `spec` holds. */
export function slider(spec) {
  return html`<slide-bar .spec=${spec}></slide-bar>`;
}
