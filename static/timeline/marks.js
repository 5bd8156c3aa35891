// The marks of the timeline. Where two lie over each other the pointer means the one that stands first here.

import { isIn } from './draw/scale.js';
import { bodyRow, bond } from './marks/bodies.js';
import { cameraFinding, cameraKey, cameraLane } from './marks/camera.js';
import { curveKey } from './marks/curve_keys.js';
import { draft } from './marks/drafts.js';
import { filmMinimum, filmStrip } from './marks/films.js';
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

/** @type {import('./mark.js').Mark[]} */
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
  bond,
  bodyRow,
  cameraKey,
  cameraFinding,
  cameraLane,
  filmMinimum,
  filmStrip,
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
