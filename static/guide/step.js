// What a step of the guide may have: no code.

/**
 * @typedef {object} Choice  A button on the card; one that `ends` the step leads on.
 * @property {string} label
 * @property {string} [title]
 * @property {() => unknown} act
 * @property {boolean} [ends]
 */

/**
 * @typedef {object} Step
 * @property {string} [name]
 * @property {string} [tool]
 * @property {string} [word]
 * @property {string} [title]
 * @property {string} [text]
 * @property {{ view: string, kinds: string[] }} [takes]  Which handles are to be dragged, and where.
 * @property {boolean} [again]  It is rarely done with one drag, so the card waits for Next instead of
 *   moving on by itself.
 * @property {boolean} [rings]  It needs those of the waist.
 * @property {Choice[]} [choices]
 * @property {string} [also]  Another of the server's keys that does it as well.
 * @property {() => boolean} [needed]  Where it is of some films alone.
 * @property {() => boolean} [done]  Where the server has no key for it.
 * @property {() => boolean} [unsure]  Whether what is done is not sure enough for a tick.
 * @property {() => unknown} [content]  More on the card, below the text.
 * @property {() => unknown} [beside]  What stands over the picture meanwhile.
 * @property {(key: string) => boolean} [key]  Keys of its own; whether it was one.
 * @property {() => { label: string, act: () => void } | null} [next]  What goes on, where it is more than that.
 * @property {() => void} [leave]  Done when going on.
 * @property {[string, string][]} [hints]  For the status bar.
 * @property {boolean} [byHand]  It may be left for posing by hand.
 */

export {};
