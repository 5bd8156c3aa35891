// What everything stands on: panel, field, lines between the rows, and words where nothing is yet.

import { svg, nothing } from '../../vendor/lit-html/lit-html.js';
import { server, ui } from '../../store/state.js';
import { isSurface } from '../../store/subject.js';
import { GUTTER, frameCount, right } from './scale.js';
import { hasCurve } from './curve.js';

const nothingYet = () =>
  isSurface()
    ? 'How well the surface shows each part, and the joint angles, appear here after the first fit.'
    : 'What the image tells about each part, and the joint angles, appear here after the first track.';

export function drawGround(rows) {
  const { width, height } = ui.timeSize;
  const across = (y) => `M0 ${y - 0.5}H${width}`;
  const lines = [across(rows.top), across(rows.keys.y + rows.keys.h)];
  if (rows.curve !== null && rows.lanes.full > 0) lines.push(across(rows.curve.y - 2));
  return svg`<rect class="f-panel" width=${width} height=${height} />
    <rect class="f-ground field" x=${GUTTER} width=${Math.max(0, width - GUTTER)} height=${height} />
    <path class="s-line" d=${`M${GUTTER + 0.5} 0V${height}${lines.join('')}`} />`;
}

export function drawKeyLabels(rows) {
  if (!server.file) return nothing;
  const y = rows.keys.middle + 4;
  return svg`<text class="lbl" x="12" y=${y}>Keyframes</text>
    <text class="d" x=${GUTTER - 10} y=${y} text-anchor="end">${server.keys?.frames.length ?? 0}</text>`;
}

/** Words in the place of lanes and curve before the first track. */
export function drawNothingYet(rows, empty, score) {
  if (!empty || score || frameCount() === 0) return nothing;
  const top = rows.keys.y + rows.keys.h;
  const room = rows.height - top;
  if (hasCurve() || room < 24) return nothing;
  return svg`<text class="d" x=${(GUTTER + right()) / 2} y=${top + room / 2 + 4}
    text-anchor="middle">${nothingYet()}</text>`;
}
