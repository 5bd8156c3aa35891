// Dragging a diamond of the curve up or down changes that key's angle.

import { server } from '../../store/state.js';
import { Stroke } from '../../controls/stroke.js';
import { axis, freezeRange, scale, valueAt } from '../draw/curve.js';
import { goTo, hold as stopPlaying } from './head.js';
import { hold } from './held.js';

const FINE = 0.1;
const STEP_DEG = 5;

/** Take hold of a key on the curve; the whole drag is one stroke, so one step of undo. */
export function grabAngle(at, row, start) {
  const part = server.curve.part;
  const about = axis();
  const from = valueAt(at);
  const degPerPx = scale(row).value(0) - scale(row).value(1);
  const stroke = new Stroke('angle', (value) => (
    { do: 'key_angle', frame: at, part, axis: about, deg: value }
  ));
  let y = start.y;
  let deg = from;
  let begun = false;
  const begin = () => {
    begun = true;
    freezeRange(true);
    goTo(at);
  };
  const letGo = () => {
    hold(null);
    freezeRange(false);
  };
  stopPlaying();
  return {
    edits: true,
    move(place) {
      if (!begun) begin();
      // Step by step, so that Shift may be pressed midway without a jump.
      deg += (y - place.y) * degPerPx * (place.shift ? FINE : 1);
      y = place.y;
      const value = place.ctrl ? Math.round(deg / STEP_DEG) * STEP_DEG : Math.round(deg * 10) / 10;
      hold({ kind: 'angle', frame: at, axis: about, part, from, deg: value });
      stroke.move(value);
    },
    click: () => goTo(at),
    end() {
      stroke.end();
      letGo();
    },
    cancel() {
      stroke.cancel();
      letGo();
    },
  };
}
