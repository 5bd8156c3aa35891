// The marks of the timeline. Where two lie over each other the pointer means the one that stands first here.

import { isIn } from './draw/scale.js';
import { cameraFinding, cameraKey, cameraLane } from './marks/camera.js';
import { curveKey } from './marks/curve_keys.js';
import { draft } from './marks/drafts.js';
import { frames } from './marks/frames.js';
import { edge, keysRow } from './marks/keys_row.js';
import { keyframe } from './marks/keyframes.js';
import { lane } from './marks/lanes.js';
import { note } from './marks/notes.js';
import { overview } from './marks/overview.js';
import { partKeyframe } from './marks/part_keyframes.js';
import { pin, proposal } from './marks/pins.js';
import { proposedKeyframes } from './marks/proposed_keyframes.js';
import { reviewPlace } from './marks/review_places.js';
import { scoreChart } from './marks/scores.js';
import { segment } from './marks/segments.js';
import { selection } from './marks/selection.js';
import { span } from './marks/span.js';

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
 * @property {'keys' | 'camera'} [row]  The row that it is hit in alone.
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

/** @type {Mark[]} */
export const MARKS = [
  selection,
  span,
  edge,
  overview,
  note,
  reviewPlace,
  keyframe,
  partKeyframe,
  draft,
  segment,
  keysRow,
  cameraKey,
  cameraFinding,
  cameraLane,
  pin,
  proposal,
  lane,
  scoreChart,
  curveKey,
  proposedKeyframes,
  frames,
];

export const markOf = (kind) => MARKS.find((mark) => mark.kind === kind);

/** The mark at a place, and which one of its kind. */
export function under(place, stage) {
  for (const mark of MARKS) {
    const isThere = mark.hit && (!mark.row || isIn(stage.rows[mark.row], place.y));
    const what = isThere ? mark.hit(place, stage) : null;
    if (what) return { mark, what: { ...what, kind: mark.kind } };
  }
  return { mark: frames, what: { kind: frames.kind } };
}
