// From the top down: where the ruler, the keyframes, the lanes and the curve stand.

export const RULER = 22;
export const OVERVIEW = 6;
const KEYS = 34;
const GAP = 4;
const LANE = { least: 14, most: 22, weakest: 18 };
const CURVE_LEAST = 40;
const ROOM_FOR_LANES = 80;

/**
 * Rows of a drawing `height` px high with `lanes` lanes; `weakest` says the one lane stands alone.
 * Lanes that do not fit are scrolled (`lanes.room` < `lanes.full`); a low drawing drops its curve.
 */
export function rowsFor({ height, zoomed, lanes, weakest }) {
  const top = RULER + (zoomed ? OVERVIEW : 0);
  const keys = { y: top, h: KEYS, middle: top + KEYS / 2 };
  const below = top + KEYS;
  const room = Math.max(0, height - below);
  const each = laneHeight(room, lanes, weakest);
  const full = lanes * each;
  const forLanes = lanes === 0 ? 0 : Math.max(0, Math.min(full, room - CURVE_LEAST - 16, room - GAP));
  // Whole lanes only, one at least: half a lane reads as a low one.
  const whole = lanes === 0 ? 0 : Math.max(1, Math.floor(forLanes / each)) * each;
  const shown = Math.min(whole, Math.max(0, room - GAP));
  const laneRow = { y: below + GAP, each, full, room: shown };
  const curveTop = lanes === 0 ? below : laneRow.y + shown + 6;
  const rest = height - curveTop - 6;
  const curve = rest >= 24 ? { y: curveTop, h: rest } : null;
  return { height, top, keys, lanes: laneRow, curve };
}

/** Whether a drawing this high has no room for more than the weakest part's lane. */
export function isCramped(height) {
  return height - RULER - KEYS < ROOM_FOR_LANES;
}

function laneHeight(room, lanes, weakest) {
  if (weakest) return LANE.weakest;
  // A tall timeline gives its lanes air, but never more than half of it.
  const fair = Math.floor((room * 0.5) / Math.max(1, lanes));
  return Math.min(LANE.most, Math.max(LANE.least, fair));
}
