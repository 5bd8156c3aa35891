// The controls every room shares. Each is a function that gives a lit-html template; the ones
// with a life of their own (held, typed into, opened) are custom elements behind it.

export { numberField } from './number.js';
export { slider } from './slider.js';
export { dropdown } from './dropdown.js';
export { textField } from './text.js';
export { checkbox, segmented, button, iconButton, tip } from './buttons.js';
export { shortNumber } from './arithmetic.js';
