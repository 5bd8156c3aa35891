// A small picture of what can be opened, fetched once it is to be seen; a sign where there is none.

import { html } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';
import { fetchOwn } from '../store/storage.js';

const MOST_AT_A_TIME = 3;
const MOST_KEPT = 400;

/** Addresses of fetched pictures: null where there is none. */
const kept = new Map();
let underWay = 0;
const waiting = [];

class SmallPicture extends HTMLElement {
  #address = '';

  /** @type {{ address: string, own?: boolean }} */
  set spec({ address, own = false }) {
    if (address === this.#address) return;
    this.#address = address;
    // A new element: the one before would show the other picture until its own has come.
    this.querySelector('img')?.remove();
    observer.unobserve(this);
    if (address && own) observer.observe(this);
    else if (address) this.show(address);
  }

  get address() {
    return this.#address;
  }

  disconnectedCallback() {
    observer.unobserve(this);
  }

  show(address) {
    const image = new Image();
    image.alt = '';
    image.draggable = false;
    image.addEventListener('error', () => image.remove());
    image.src = address;
    this.prepend(image);
  }

  /** Fetch it with the key, which an address in the page could not carry. */
  async fetch() {
    const address = this.#address;
    if (!kept.has(address)) await inTurn(() => keep(address));
    const found = kept.get(address);
    if (found && address === this.#address && this.isConnected) this.show(found);
  }
}

async function keep(address) {
  if (kept.has(address)) return;
  try {
    const response = await fetchOwn(address);
    if (response.ok) kept.set(address, URL.createObjectURL(await response.blob()));
    else if (response.status === 404) kept.set(address, null);
  } catch {
    return; // the line is down: another time
  }
  if (kept.size <= MOST_KEPT) return;
  const [oldest, object] = kept.entries().next().value;
  kept.delete(oldest);
  if (object) URL.revokeObjectURL(object);
}

/** Few at a time, so that what is asked for meanwhile does not wait behind them. */
async function inTurn(act) {
  if (underWay >= MOST_AT_A_TIME) await new Promise((resolve) => waiting.push(resolve));
  underWay += 1;
  try {
    await act();
  } finally {
    underWay -= 1;
    waiting.shift()?.();
  }
}

const observer = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) {
    if (!isIntersecting || !(target instanceof SmallPicture)) continue;
    observer.unobserve(target);
    target.fetch();
  }
});

customElements.define('small-picture', SmallPicture);

/** @param {{ address: string, own?: boolean, sign?: string }} spec  own: only this page may fetch it. */
export const smallPicture = ({ address, own = false, sign = 'film' }) =>
  html`<small-picture class="th" .spec=${{ address, own }}>${icon(sign)}</small-picture>`;
