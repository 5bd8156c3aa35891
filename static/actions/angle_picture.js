// The chart of a joint's angle as a picture of its own, dark on white, for a report or a slide.

/** @typedef {import('../store/shapes.js').JointAngle} JointAngle */

const WIDTH = 1600;
const HEIGHT = 700;
const ROOM = { left: 110, right: 40, top: 110, bottom: 80 };
const COLOURS = { L: '#2563c9', R: '#d9730d', C: '#444' };
/** What the sides are called. */
export const SIDES = { L: 'Left', R: 'Right', C: '' };
/** Degrees between two lines of a grid. */
export const STEPS = [1, 2, 5, 10, 20, 30, 45, 60, 90, 180];
const SECONDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 300, 600];

/** Round values over a range, some of them. */
export function ticksOf(low, high, steps, most) {
  const step = steps.find((each) => (high - low) / each <= most) ?? steps.at(-1);
  const ticks = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9; n += 1) ticks.push(Number((n * step).toFixed(6)));
  return ticks;
}

/**
 * The lowest and the highest value of all sides, with what they may be off by, and some air between them.
 * @param {JointAngle} shown
 * @returns {[number, number]}
 */
export function angleRange({ sides }) {
  const off = (side, at) => side.errors?.[at] ?? 0;
  const values = sides.flatMap((side) =>
    side.values.flatMap((value, at) => (value === null ? [] : [value - off(side, at), value + off(side, at)])),
  );
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const air = Math.max(0.08 * (high - low), (10 - (high - low)) / 2);
  return [low - air, high + air];
}

/**
 * @param {JointAngle} shown
 * @param {[number, number]} frames
 * @param {(frame: number) => number} secondsAt
 */
export function drawAngleChart(shown, [first, last], secondsAt) {
  const canvas = document.createElement('canvas');
  canvas.width = WIDTH;
  canvas.height = HEIGHT;
  const pen = canvas.getContext('2d');
  const [low, high] = angleRange(shown);
  const [from, to] = [secondsAt(first), Math.max(secondsAt(last), secondsAt(first) + 1e-6)];
  const x = (seconds) => ROOM.left + ((seconds - from) * (WIDTH - ROOM.left - ROOM.right)) / (to - from);
  const y = (value) => HEIGHT - ROOM.bottom - ((value - low) * (HEIGHT - ROOM.top - ROOM.bottom)) / (high - low);
  pen.fillStyle = '#fff';
  pen.fillRect(0, 0, WIDTH, HEIGHT);
  grid(pen, { x, y, low, high, from, to });
  title(pen, shown);
  for (const { side, values } of shown.sides) {
    pen.strokeStyle = COLOURS[side];
    pen.lineWidth = 4;
    pen.lineJoin = 'round';
    pen.beginPath();
    let isOn = false;
    for (let frame = first; frame <= last; frame += 1) {
      const value = values[frame] ?? null;
      if (value !== null) pen[isOn ? 'lineTo' : 'moveTo'](x(secondsAt(frame)), y(value));
      isOn = value !== null;
    }
    pen.stroke();
  }
  return canvas;
}

function grid(pen, { x, y, low, high, from, to }) {
  pen.font = '24px Inter, sans-serif';
  pen.fillStyle = '#555';
  pen.lineWidth = 1.5;
  pen.textAlign = 'right';
  pen.textBaseline = 'middle';
  for (const value of ticksOf(low, high, STEPS, 8)) {
    pen.strokeStyle = value === 0 ? '#888' : '#e3e3e3';
    stroke(pen, ROOM.left, y(value), WIDTH - ROOM.right, y(value));
    pen.fillText(`${value}°`, ROOM.left - 14, y(value));
  }
  pen.textAlign = 'center';
  for (const seconds of ticksOf(from, to, SECONDS, 12)) {
    pen.fillText(`${seconds} s`, x(seconds), HEIGHT - ROOM.bottom + 34);
  }
}

function title(pen, { label, positive, negative, sides }) {
  pen.textAlign = 'left';
  pen.fillStyle = '#111';
  pen.font = '600 34px Inter, sans-serif';
  pen.fillText(label, ROOM.left, 42);
  pen.font = '24px Inter, sans-serif';
  pen.fillStyle = '#666';
  pen.fillText(`+ ${positive}, − ${negative}`, ROOM.left, 82);
  pen.textAlign = 'right';
  let at = WIDTH - ROOM.right;
  for (const { side } of [...sides].reverse()) {
    if (!SIDES[side]) continue;
    pen.fillStyle = COLOURS[side];
    pen.font = '600 26px Inter, sans-serif';
    pen.fillText(SIDES[side], at, 42);
    at -= pen.measureText(SIDES[side]).width + 32;
  }
}

function stroke(pen, x0, y0, x1, y1) {
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}
