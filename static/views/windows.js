// The window of a view: which stretch of its plane is on the screen. The plane's coordinates are
// those of the protocol: pixels of the picture in the main view, centres at integers, and metres,
// x right and y down, in the others.

import { clamp } from '../controls/arithmetic.js';

export class Window {
  /** Point of the plane in the middle of the screen. */
  x = 0;
  y = 0;
  /** Screen pixels per unit of the plane. */
  scale = 1;
  width = 1;
  height = 1;
  /** Whether a person chose this window; one that was not chosen follows what it shows. */
  chosen = false;

  #limits = [1e-3, 1e6];

  /** Least and greatest scale. */
  limit(least, greatest) {
    this.#limits = [least, greatest];
  }

  toPlane([x, y]) {
    return [this.x + (x - this.width / 2) / this.scale, this.y + (y - this.height / 2) / this.scale];
  }

  fromPlane([a, b]) {
    return [this.width / 2 + (a - this.x) * this.scale, this.height / 2 + (b - this.y) * this.scale];
  }

  /** What lies at this screen point stays there. */
  zoomAt(x, y, factor) {
    const [a, b] = this.toPlane([x, y]);
    this.scale = this.#within(this.scale * factor);
    this.x = a - (x - this.width / 2) / this.scale;
    this.y = b - (y - this.height / 2) / this.scale;
    this.chosen = true;
  }

  panBy(dx, dy) {
    this.x -= dx / this.scale;
    this.y -= dy / this.scale;
    this.chosen = true;
  }

  resize(width, height) {
    this.width = Math.max(1, width);
    this.height = Math.max(1, height);
  }

  /** Show a box [left, top, right, bottom] of the plane whole, with room around it in pixels. */
  showBox(box, room = { x: 0, top: 0, bottom: 0 }, greatestScale = Infinity) {
    const wide = Math.max(1, this.width - 2 * room.x);
    const high = Math.max(1, this.height - room.top - room.bottom);
    const scale = Math.min(wide / (box[2] - box[0]), high / (box[3] - box[1]));
    this.scale = this.#within(Math.min(scale, greatestScale));
    this.x = (box[0] + box[2]) / 2;
    this.y = (box[1] + box[3]) / 2 - (room.top - room.bottom) / 2 / this.scale;
    this.chosen = false;
  }

  /** Whether a box of the plane is wholly, or at all, on the screen. */
  holds(box) {
    const [left, top] = this.fromPlane([box[0], box[1]]);
    const [right, bottom] = this.fromPlane([box[2], box[3]]);
    return left >= 0 && top >= 0 && right <= this.width && bottom <= this.height;
  }

  touches(box) {
    const [left, top] = this.fromPlane([box[0], box[1]]);
    const [right, bottom] = this.fromPlane([box[2], box[3]]);
    return right > 0 && bottom > 0 && left < this.width && top < this.height;
  }

  #within(scale) {
    return clamp(scale, ...this.#limits);
  }
}
