// A number: drag it sideways, type into it, nudge it with arrows or the wheel.
//
// By hand: the browser's own, `type="number"`, is not dragged and takes neither sums nor units.

import { html } from '../vendor/lit-html/lit-html.js';
import { read, shortNumber } from './arithmetic.js';
import { hush, say, shake } from './buttons.js';
import { followValue, ValueElement } from './value.js';

const DRAG_STARTS_PX = 3;

class NumberField extends ValueElement {
  mark = document.createElement('b');
  input = document.createElement('input');
  unit = document.createElement('u');

  build() {
    this.classList.add('n');
    this.input.setAttribute('role', 'spinbutton');
    this.input.inputMode = 'decimal';
    this.input.autocomplete = 'off';
    this.input.spellcheck = false;
    this.append(this.mark, this.input, this.unit);
    this.addEventListener('mousedown', (event) => this.keepFocusAway(event));
    this.addEventListener('pointerdown', (event) => this.press(event));
    this.addEventListener('wheel', (event) => this.roll(event), { passive: false });
    this.input.addEventListener('focus', () => this.enter());
    this.input.addEventListener('blur', () => this.exit());
    this.input.addEventListener('keydown', (event) => this.key(event));
    this.input.addEventListener('input', () => this.onInput());
  }

  get isFocused() {
    return document.activeElement === this.input;
  }

  get isInHand() {
    return this.isFocused || super.isInHand;
  }

  draw() {
    const { label, unit = '', off = '', mark, min, max, limit, title } = this.spec;
    this.classList.toggle('edit', this.isFocused);
    this.classList.toggle('dragged', this.isDragged === true);
    this.classList.toggle('limit', this.isAtLimit);
    this.classList.toggle('off', off !== '');
    this.input.readOnly = off !== '';
    this.title = off || title || `${label}: drag sideways or type, also +5 or 30/2`;
    this.unit.textContent = unit;
    this.mark.textContent = mark?.text ?? '';
    this.mark.style.color = mark?.color ?? '';
    if (!this.isFocused || this.nudged) this.input.value = this.text;
    this.describe(label, unit, limit ?? [min, max], off);
  }

  get text() {
    const value = this.value;
    return value === null || value === undefined ? '–' : shortNumber(value, this.decimals);
  }

  get decimals() {
    return this.spec.decimals ?? 1;
  }

  describe(label, unit, [low, high], off) {
    const facts = {
      'aria-label': label,
      'aria-valuenow': this.value ?? '',
      'aria-valuetext': `${this.text}${unit === '°' ? '' : ' '}${unit}`,
      'aria-disabled': off !== '',
    };
    for (const [name, value] of Object.entries(facts)) this.input.setAttribute(name, value);
    bound(this.input, 'aria-valuemin', low);
    bound(this.input, 'aria-valuemax', high);
  }

  // --- the pointer

  /** A press may become a drag: the caret comes only when it did not. */
  keepFocusAway(event) {
    if (this.isFocused) return;
    event.preventDefault();
    document.activeElement?.blur();
  }

  press(event) {
    if (this.isFocused || event.button !== 0 || this.spec.off) return;
    if (this.spec.value === null) {
      // nothing to drag from: it is typed
      this.begin();
      return;
    }
    const from = { x: event.clientX, start: this.value, travel: 0, moved: false };
    followValue(this, event, {
      move: (now) => this.drag(from, now),
      end: () => this.release(from),
      cancel: () => this.drop(),
    });
  }

  drag(from, event) {
    const dx = event.clientX - from.x;
    if (!from.moved && Math.abs(dx) < DRAG_STARTS_PX) return;
    from.moved = true;
    from.x = event.clientX;
    // Summed, so that Shift may be pressed and released midway without a jump.
    from.travel += dx * (event.shiftKey ? 0.1 : 1);
    const value = from.start + from.travel * (this.spec.perPixel ?? this.steps / 2);
    const coarse = this.spec.coarse ?? this.steps * 5;
    this.isDragged = true;
    this.moveTo(event.ctrlKey ? Math.round(value / coarse) * coarse : value);
  }

  release(from) {
    this.isDragged = false;
    if (from.moved) {
      this.finish();
      this.draw();
    } else {
      this.begin();
    }
  }

  /** The caret comes by a press. */
  begin() {
    this.input.focus({ preventScroll: true });
    this.byMouse = true;
  }

  drop() {
    this.isDragged = false;
    this.cancelStroke();
    this.draw();
  }

  roll(event) {
    if (!this.isFocused) return;
    event.preventDefault();
    const notches = this.notches(event);
    if (notches !== 0) this.nudgeText(notches * this.stride(event));
  }

  // --- the keyboard

  enter() {
    this.byMouse = false;
    this.dirty = false;
    this.nudged = false;
    this.input.value = this.text;
    this.input.select();
    this.draw();
  }

  exit() {
    this.finish();
    if (this.dirty && !this.left) this.commit();
    this.dirty = false;
    this.nudged = false;
    this.draw();
  }

  onInput() {
    hush();
    this.finish();
    this.dirty = true;
    this.nudged = false;
  }

  key(event) {
    const way = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    const known = way !== undefined || event.key === 'Enter' || event.key === 'Escape';
    if (!known) return;
    event.preventDefault();
    event.stopPropagation();
    if (way !== undefined) this.nudgeText(way * this.stride(event));
    else if (event.key === 'Enter') this.accept();
    else this.restore();
  }

  nudgeText(amount) {
    if (this.spec.off || this.spec.value === null) return;
    if (this.dirty && !this.commit()) return;
    this.dirty = false;
    this.nudged = true;
    this.nudge(amount);
    this.input.select();
  }

  accept() {
    this.finish();
    if (this.dirty && !this.commit()) {
      this.input.select();
      return;
    }
    this.dirty = false;
    // The mouse brought the caret, so the keys go back to the frame; Tab's visitors stay.
    if (this.byMouse) this.input.blur();
    else this.enter();
  }

  restore() {
    hush();
    this.cancelStroke();
    this.dirty = false;
    this.input.blur();
  }

  /** Take over what was typed; false when it makes no sense. */
  commit() {
    if (this.spec.off) return true;
    const { label, unit = '', min = -Infinity, max = Infinity } = this.spec;
    const { value, words } = read(this.input.value, this.value ?? 0, unit);
    const refusal = words ?? outside(value, min, max, label, this.decimals, unit);
    if (refusal) {
      shake(this);
      say(this, refusal);
      return false;
    }
    if (this.input.value !== this.text) this.setTo(value);
    return true;
  }

  /** It stands for something else now: what was typed was meant for the other. */
  leave() {
    this.left = true;
    this.dirty = false;
    if (this.isFocused) this.input.blur();
    this.left = false;
  }
}

function bound(element, name, value) {
  if (Number.isFinite(value)) element.setAttribute(name, value);
  else element.removeAttribute(name);
}

function outside(value, min, max, label, decimals, unit) {
  if (value >= min && value <= max) return null;
  const space = unit === '°' || unit === '' ? '' : ' ';
  const word = (x) => `${shortNumber(x, decimals).replace(/\.0+$/, '')}${space}${unit}`;
  if (!Number.isFinite(max)) return `${label} is at least ${word(min)}.`;
  if (!Number.isFinite(min)) return `${label} is at most ${word(max)}.`;
  return `${label} goes from ${word(min)} to ${word(max)}.`;
}

customElements.define('number-field', NumberField);

/** A number field; see value.js for what `spec` holds. */
export function numberField(spec) {
  return html`<number-field .spec=${spec}></number-field>`;
}
