// Which frame is due while the film plays, as a pure function of the time: however late pictures come,
// playing keeps time and leaves frames out.

/**
 * One way of playing, until something about it changes.
 * @typedef {object} Run
 * @property {number} from  The frame it begins with.
 * @property {number} began  Milliseconds.
 * @property {number} rate  1 is as fast as it was filmed; negative: backward.
 * @property {number} first  Of the frames that are played.
 * @property {number} last
 * @property {boolean} loops
 * @property {number} fps
 * @property {number[] | null} times  Seconds of every frame, where the rate varies.
 */

/** @typedef {{ frame: number, lap: number, over: boolean }} Due  lap: how often it began anew. */

const TINY_S = 1e-6;
/** No screen shows more pictures a second. */
const MOST_SHOWN = 60;

/** When a frame begins and ends, in seconds of the film. */
const beginOf = ({ times, fps }, frame) => (times ? times[frame] - times[0] : frame / fps);

function endOf(run, frame) {
  const { times, fps } = run;
  if (!times || frame + 1 < times.length) return beginOf(run, frame + 1);
  return beginOf(run, frame) + 1 / fps;
}

/** The frame seen at a time of the film: the last that has begun. */
function frameAt(run, seconds) {
  const { times, fps } = run;
  if (!times) return Math.floor((seconds + TINY_S) * fps);
  let [low, high] = [0, times.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (beginOf(run, middle) <= seconds + TINY_S) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** @param {Run} run @param {number} now @returns {Due} */
export function dueAt(run, now) {
  const { from, rate, first, last, loops } = run;
  const way = Math.sign(rate);
  const [start, goal] = way > 0 ? [first, last] : [last, first];
  const spent = (Math.max(0, now - run.began) / 1000) * Math.abs(rate);
  const toEnd = way > 0 ? endOf(run, last) - beginOf(run, from) : endOf(run, from) - beginOf(run, first);
  if (spent < toEnd - TINY_S) return { frame: after(run, from, spent), lap: 0, over: false };
  if (!loops) return { frame: goal, lap: 0, over: true };
  const whole = endOf(run, last) - beginOf(run, first);
  const laps = Math.floor((spent - toEnd + TINY_S) / whole);
  return { frame: after(run, start, spent - toEnd - laps * whole), lap: laps + 1, over: false };
}

/** The frame so many seconds of the film after one began to be seen. */
function after(run, frame, seconds) {
  if (run.rate > 0) return Math.min(run.last, frameAt(run, beginOf(run, frame) + seconds));
  return Math.max(run.first, frameAt(run, endOf(run, frame) - seconds - 2 * TINY_S));
}

/** The same with something changed at a time: it goes on from the frame due then. @returns {Run} */
export const changedAt = (run, now, changes) => ({ ...run, from: dueAt(run, now).frame, began: now, ...changes });

/**
 * The next frames worth having, at most so many: fewer of each second where more are played than a
 * screen shows; at the end those it begins anew with.
 * @param {Run} run
 */
export function framesAhead(run, frame, most) {
  const way = Math.sign(run.rate);
  const stride = Math.max(1, Math.floor((Math.abs(run.rate) * run.fps) / MOST_SHOWN));
  const [start, goal] = way > 0 ? [run.first, run.last] : [run.last, run.first];
  const ahead = [];
  let at = frame;
  while (ahead.length < most) {
    const next = at === goal ? null : nextStep(at, goal, way, stride);
    if (next === null && !run.loops) break;
    at = next ?? start;
    if (ahead.includes(at)) break;
    ahead.push(at);
  }
  return ahead;
}

/** To the next multiple of the stride, so that each step wants the same frames; never beyond the goal. */
function nextStep(at, goal, way, stride) {
  const next = way > 0 ? (Math.floor(at / stride) + 1) * stride : (Math.ceil(at / stride) - 1) * stride;
  return way * (next - goal) > 0 ? goal : next;
}

/**
 * What is played from a frame on: what a person chose, else as far as there are keyframes; all of the
 * film where there are none, or from beyond them. Begun at its end it begins anew.
 * @param {{ lastFrame: number, keys: number[], span: { first: number | null, last: number | null }, at: number, way?: number }} here
 */
export function rangeToPlay({ lastFrame, keys, span, at, way = 1 }) {
  if (span.first !== null || span.last !== null) {
    const range = { first: span.first ?? 0, last: span.last ?? lastFrame };
    const isInside = range.first <= at && at <= range.last;
    return { ...range, from: isInside ? fromWithin(range, at, way) : way > 0 ? range.first : range.last };
  }
  const all = { first: 0, last: lastFrame };
  const keyed = keys.length > 1 ? { first: keys[0], last: keys[keys.length - 1] } : all;
  const isBeyond = way > 0 ? at > keyed.last && at < lastFrame : at < keyed.first && at > 0;
  if (isBeyond) return { ...keyed, [way > 0 ? 'last' : 'first']: way > 0 ? lastFrame : 0, from: at };
  return { ...keyed, from: fromWithin(keyed, at, way) };
}

function fromWithin({ first, last }, at, way) {
  if (way > 0) return at >= last ? first : at;
  return at <= first ? last : at;
}

const RATES = [-4, -2, -1, 1, 2, 4];

/** The rate after J (−1) or L (+1), as editors have it. */
export function shuttled(rate, way) {
  const at = RATES.indexOf(rate) + way;
  return RATES[Math.max(0, Math.min(RATES.length - 1, at))];
}
