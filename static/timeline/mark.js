// What a mark of the timeline may have: no code.

/**
 * @typedef {{ x: number, y: number, ctrl?: boolean, shift?: boolean, alt?: boolean, page?: [number, number] }} Place
 */
/** @typedef {{ rows: any, lanes: any[], scroll: number, empty: boolean, bottom: number }} Stage
 * What the drawing stands on; `bottom` is where frames end, `empty` whether there are no lanes yet. */

/**
 * Drawn anew when any of `from` is another than before. `z` is the order within its group.
 * @typedef {{ group: 'back' | 'frames' | 'above' | 'top', z: number, from: () => unknown[], draw: (stage: Stage) => unknown }} Layer
 */

/**
 * What a press begins. What `move` returns is grabbed until the pointer is released, and given to `end`.
 * @typedef {{ move: (place: Place) => any, end?: (held: any) => void, cancel?: () => void }} Gesture
 */

/**
 * `hit` tells which one is at a place, and the rest is about that one: `click` is a press without a drag,
 * `open` a double click, `drag` draws it while it is grabbed, `tip` while the pointer is over it.
 * `edits` is whether keys wait until the gesture is over.
 * @typedef {object} Mark
 * @property {string} kind
 * @property {Layer[]} [layers]
 * @property {'keys' | 'bodies' | 'camera' | 'films'} [row]  The row that it is hit in alone.
 * @property {(place: Place, stage: Stage) => any} [hit]
 * @property {string | ((what: any) => string)} [cursor]
 * @property {boolean} [edits]
 * @property {(what: any, place: Place, stage: Stage) => Gesture | null} [grab]
 * @property {(what: any, place: Place) => void} [click]
 * @property {(what: any) => void} [open]
 * @property {(what: any, place: Place) => void} [menu]
 * @property {(what: any, rows: any) => unknown} [tip]
 * @property {(held: any, rows: any) => unknown} [drag]
 */

export {};
