// The drawing is a stack of layers, each drawn again only when something it is drawn from changed:
// the playhead moves over lanes and curves that stay as they are.

import { render } from '../../vendor/lit-html/lit-html.js';

/** A function that draws the layer if any of its inputs is another than the last time. */
export function layer(element, inputs, draw) {
  let before = null;
  return () => {
    const now = inputs();
    if (before !== null && now.every((value, i) => Object.is(value, before[i]))) return;
    before = now;
    render(draw(), element);
  };
}

/** Remember the last result of a function while its arguments stay the same. */
export function remembered(compute) {
  let args = null;
  let result;
  return (...now) => {
    if (args === null || now.some((value, i) => !Object.is(value, args[i]))) {
      result = compute(...now);
      args = now;
    }
    return result;
  };
}
