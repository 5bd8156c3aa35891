// The controls every room shares. Each is a function that gives a lit-html template; the ones
// with a life of their own (held, typed into, opened) are custom elements behind it.

export { numberField } from './fields/number.js';
export { slider } from './fields/slider.js';
export { dropdown } from './fields/dropdown.js';
export { textField } from './fields/text.js';
export { checkbox, segmented, button, iconButton, tip } from './fields/buttons.js';
export { shortNumber } from './fields/arithmetic.js';
