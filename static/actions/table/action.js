// What an entry of the table of actions is: no code.

/**
 * A text, or one made of the state and of what it is about, such as a frame or a segment.
 * @typedef {string | ((about?: any) => string)} Text
 */

/**
 * One thing that can be done: by a message to the server, or by a function of the page.
 * @typedef {object} Action
 * @property {Text} label  in menus, on buttons, to screen readers and on the sheet of keys
 * @property {Text} [title]  the tip, where the label does not say enough
 * @property {string} [also]  what else people call it: the command search finds it by these words too
 * @property {string} [alone]  what it is called without the heading of the menu or bar it is from
 * @property {Text} [icon]
 * @property {string[]} [keys]  chords as "Ctrl Shift Z"; the first is shown beside the label
 * @property {string[]} [aliases]  chords that work as well and are shown nowhere
 * @property {string} [row]  on the sheet of keys; neighbours with the same words share a line
 * @property {(about?: any) => string} [off]  why it cannot be done now, or ''
 * @property {(about?: any) => boolean} [on]  whether it is switched on, or the one that is chosen
 * @property {(about?: any) => { do: string }} [message]
 * @property {(...about: any[]) => unknown} [run]
 * @property {boolean} [repeats]  while its key stays down; where it leads nowhere, nothing is said
 * @property {boolean} [always]  also while no file is open
 * @property {'drag' | 'pointer' | 'escape' | 'release' | 'review' | 'playing' | 'paste'} [handledBy]  what
 *   handles its keys, if not the keyboard's table: a drag, a view, Esc in its order, the release of Space, the review,
 *   playing, the browser's paste event
 */

export {};
