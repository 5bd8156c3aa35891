// The keypoints of the frame that is shown: which there are, which are unsure, and what is done with one.

import { send } from '../store/link.js';
import { server, ui } from '../store/state.js';

/** Below it a person should look. */
export const SURE = 0.65;
/** Shown where nothing is amiss. */
const TYPICAL = ['nose', 'left_wrist', 'right_wrist', 'left_ankle', 'right_ankle'];
export const FEW = 5;

/** @typedef {import('../store/shapes.js').Keypoint} Keypoint */

/** Those of the frame of the playhead. @returns {Keypoint[]} */
export const keypointsHere = () =>
  server.keypoints?.frame === server.view?.frame ? (server.keypoints?.points ?? []) : [];

/** Whether they are drawn: as chosen, else while one works at tracking. */
export const ringsAreShown = () => ui.rings ?? ui.tab === 'track';

/** @param {Keypoint} point */
export const unsure = ({ state, sure }) => state === 'found' && sure < SURE;

/** The least sure, where it is one that a person should look at. @param {Keypoint[]} points */
export function worstOf(points) {
  const [worst] = points.filter(unsure).sort((a, b) => a.sure - b.sure);
  return worst;
}

/** The worst, and besides them those that one looks at first; in the order of the body. @param {Keypoint[]} points */
export function fewOf(points) {
  const worst = points.filter(unsure).sort((a, b) => a.sure - b.sure);
  const usual = points.filter((point) => !unsure(point) && TYPICAL.includes(point.joint));
  const others = points.filter((point) => !unsure(point) && !TYPICAL.includes(point.joint));
  const chosen = [...worst, ...usual, ...others].slice(0, FEW);
  return points.filter((point) => chosen.includes(point));
}

/** "58 %"; in words what a person said. @param {Keypoint} point */
export function percentOf({ state, sure }) {
  if (state === 'ignored') return 'ignored';
  return state === 'corrected' ? 'set' : `${Math.round(100 * sure)} %`;
}

/** An arc of a circle from its top clockwise, a share of its length. */
export function arcOf(x, y, r, share) {
  if (share <= 0) return '';
  const whole = share >= 0.999;
  const turn = 2 * Math.PI * (whole ? 0.5 : share);
  const end = [x + r * Math.sin(turn), y - r * Math.cos(turn)].map((v) => v.toFixed(2));
  const arc = `M${x} ${y - r}A${r} ${r} 0 ${!whole && share > 0.5 ? 1 : 0} 1 ${end[0]} ${end[1]}`;
  return whole ? `${arc}A${r} ${r} 0 0 1 ${x} ${y - r}` : arc;
}

/** What is sent while a ring is dragged. @param {Keypoint} point */
export const correction = (point, frame, at) => ({ do: 'correct_keypoint', frame, joint: point.joint, at });

/** The entries of its menu. @param {Keypoint} point */
export function keypointActions({ joint, state }, frame) {
  const act = (what) => () => send({ do: what, frame, joint });
  return [
    {
      icon: 'reset',
      label: 'Put back',
      title: 'Where the detector found it',
      off: state === 'found' ? 'It is as it was found' : '',
      run: act('restore_keypoint'),
    },
    {
      icon: 'x',
      label: 'Ignore here',
      title: 'It does not count in this frame',
      off: state === 'ignored' ? 'Ignored already' : '',
      run: act('ignore_keypoint'),
    },
  ];
}
