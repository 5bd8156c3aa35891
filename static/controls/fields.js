// The controls every room shares. Each is a function that gives a lit-html template; the ones
// with a state of their own (dragged, typed into, opened) are custom elements behind it.

export { numberField } from './number.js';
export { slider } from './slider.js';
export { dropdown } from './dropdown.js';
export { textField } from './buttons.js';
export { checkbox, segmented, switchField, button, iconButton } from './buttons.js';
export { shortNumber } from './arithmetic.js';
