// What a tool that draws on the picture may have: no code.

/**
 * `down`, `move` and `up` are of a pointer on the main view, `cancel` ends the press as if it had not
 * been. `key` is true for a key of the tool. `words` say what to do now, `hints` which keys there are.
 * @typedef {object} Tool
 * @property {string} icon
 * @property {string[][]} hints
 * @property {() => string} words
 * @property {(view: any, x: number, y: number) => void} [down]
 * @property {(view: any, x: number, y: number) => void} [move]
 * @property {(view: any, x: number, y: number) => void} up
 * @property {() => void} [cancel]
 * @property {() => void} [forget]  The tool is taken up anew.
 * @property {(event: KeyboardEvent, name: string) => boolean} [key]
 * @property {(view: any) => string} [cursor]
 * @property {(view: any) => unknown} draw
 * @property {(view: any) => unknown} [label]  Words over the picture.
 * @property {() => { label: string, key: string, off: string, act: () => void } | null} [done]  What ends it, as a button.
 */

export {};
