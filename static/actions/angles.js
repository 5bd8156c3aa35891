// The angle of a joint by its clinical name: which is charted, its values, and what is saved of it.

import { toast } from '../controls/toasts.js';
import { isSurface } from '../store/clip.js';
import { send } from '../store/link.js';
import { server } from '../store/state.js';
import { hasMotion, saveBlob } from './exporting.js';
import { drawAngleChart, SIDES } from './angle_picture.js';

/** @typedef {import('../store/shapes.js').JointAngle} JointAngle */

/** Whether the angle of this joint is charted, or of any. @param {string} [joint] */
export const isCharted = (joint) => Boolean(server.joint_angle) && (!joint || server.joint_angle?.joint === joint);

/** Why there is no angle to chart, or ''. */
export function whyNoAngle() {
  if (!server.body?.is_persons) return 'Needs a person’s body';
  const isPosed = hasMotion() || (server.keys?.drafts.length ?? 0) + (server.keys?.frames.length ?? 0) > 0;
  return isPosed ? '' : `${isSurface() ? 'Fit' : 'Track or draft'} a motion first`;
}

/** Chart an angle of a joint, by default its first. */
export const chartAngle = (joint, angle = '') => send({ do: 'joint_angle', joint, angle });

export const closeAngle = () => send({ do: 'joint_angle' });

/** The same joint again closes the chart. */
export const toggleAngle = (joint) => (isCharted(joint) ? closeAngle() : chartAngle(joint));

/** "142°"; "–" where nothing is known. @param {number | null | undefined} value */
export const degrees = (value) => (value === null || value === undefined ? '–' : `${Math.round(value)}°`);

/**
 * The lowest and the highest value of a side with their frames; null where nothing is known.
 * @param {(number | null)[]} values
 */
export function extremes(values) {
  let low = null;
  let high = null;
  values.forEach((value, frame) => {
    if (value === null) return;
    if (low === null || value < low.value) low = { frame, value };
    if (high === null || value > high.value) high = { frame, value };
  });
  return low && high && { low, high };
}

/**
 * First and last frame at which any side has a value; null without.
 * @param {JointAngle} shown
 * @returns {[number, number] | null}
 */
export function framesWithAngle({ sides }) {
  const known = sides
    .flatMap(({ values }) => [values.findIndex((v) => v !== null), values.findLastIndex((v) => v !== null)])
    .filter((frame) => frame >= 0);
  return known.length ? [Math.min(...known), Math.max(...known)] : null;
}

const nameOf = ({ side, part }) => (SIDES[side] ? SIDES[side].toLowerCase() : part);

/**
 * A table of the curves: frame, seconds, degrees of each side; empty where nothing is known.
 * @param {JointAngle} shown
 * @param {(frame: number) => number} secondsAt
 */
export function angleTable(shown, secondsAt) {
  const word = `${shown.joint}_${shown.angle}`;
  const columns = shown.sides.flatMap((side) => {
    const name = SIDES[side.side] ? `${nameOf(side)}_${word}` : word;
    const own = { head: `${name}_deg`, values: side.values };
    return side.errors ? [own, { head: `${name}_expected_error_deg`, values: side.errors }] : [own];
  });
  const head = ['frame', 'time_s', ...columns.map((column) => column.head)];
  const [first, last] = framesWithAngle(shown) ?? [0, -1];
  const rows = Array.from({ length: last - first + 1 }, (_, n) => {
    const frame = first + n;
    return [frame, secondsAt(frame).toFixed(4), ...columns.map(({ values }) => values[frame] ?? '')];
  });
  return `${[head, ...rows].map((row) => row.join(',')).join('\r\n')}\r\n`;
}

/** When a frame is shown, seconds from the first. */
export const secondsAt = (frame) => server.file?.times?.[frame] ?? frame / (server.file?.fps ?? 30);

const fileOf = ({ joint, angle }, ending) => `${server.file?.name}-${joint}-${angle.replaceAll('_', '-')}.${ending}`;

export function saveAngleTable() {
  const shown = server.joint_angle;
  if (shown) saved(new Blob([angleTable(shown, secondsAt)], { type: 'text/csv' }), fileOf(shown, 'csv'));
}

/** A PNG of the whole curve, on white. */
export function saveAnglePicture() {
  const shown = server.joint_angle;
  const frames = shown && framesWithAngle(shown);
  if (!frames) return;
  const canvas = drawAngleChart(shown, frames, secondsAt);
  canvas.toBlob((blob) => {
    if (blob) saved(blob, fileOf(shown, 'png'));
    else toast({ kind: 'check', words: 'Nothing was saved.', detail: 'This browser cannot make the picture.' });
  }, 'image/png');
}

function saved(blob, name) {
  saveBlob(blob, name);
  toast({ kind: 'good', words: `Saved as ${name}.` });
}
