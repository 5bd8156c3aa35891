// Numbers, times and verdicts as the page says them.

/** @type {Record<string, { colour: string, sign: string, word: string }>} */
export const VERDICTS = {
  good: { colour: 'good', sign: 'check', word: 'Good' },
  check: { colour: 'check', sign: 'warn', word: 'Check' },
  lost: { colour: 'lost', sign: 'lost', word: 'Lost' },
  outdated: { colour: 'old', sign: 'old', word: 'Outdated' },
  waiting: { colour: 'old', sign: 'old', word: 'Waiting' },
  tracking: { colour: 'track', sign: 'run', word: '' },
  none: { colour: 'old', sign: 'old', word: '' },
};

/** "39–50": an interval of frames. */
export const range = (first, last) => `${first}–${last}`;

/** "1 keyframe", "8 keyframes". */
export const count = (n, noun) => `${n} ${noun}${n === 1 ? '' : 's'}`;

/** "about 4 minutes": how long work will take; '' where it is short. @param {number} seconds */
export function aboutTime(seconds) {
  if (!(seconds >= SHORT_S)) return '';
  if (seconds < 55) return `about ${10 * Math.round(seconds / 10)} seconds`;
  const minutes = Math.round(seconds / 60);
  return minutes < 90 ? `about ${count(minutes, 'minute')}` : `about ${(seconds / 3600).toFixed(1)} hours`;
}

const SHORT_S = 20;

/**
 * "≈ 6.8 px · 3.2 cm", "≈ 14 px", "under 0.5 px": an error in the picture, and in space where that is known.
 * @param {number} px  Of the video.
 * @param {number | null} cm
 */
export function roughError(px, cm) {
  if (px < LEAST_PX) return `under ${LEAST_PX} px`;
  return `≈ ${[`${short(px)} px`, ...(cm === null ? [] : [`${short(cm)} cm`])].join(' · ')}`;
}

const LEAST_PX = 0.5;
const short = (n) => (n < 9.95 ? n.toFixed(1) : n.toFixed(0));

/** "a, b and c". */
export function joined(items) {
  if (items.length < 2) return items.join('');
  return `${items.slice(0, -1).join(', ')} and ${items.at(-1)}`;
}

/** "48 MB", in the steps a file manager uses. */
export function bytes(n) {
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let size = n;
  let step = 0;
  while (size >= 999.5 && step < units.length - 1) {
    size /= 1000;
    step += 1;
  }
  return `${size < 10 && step > 1 ? size.toFixed(1) : Math.round(size)} ${units[step]}`;
}

/** "2 s ago", "5 min ago", "3 h ago": how long ago something was saved. */
export function shortAgo(epoch, now = Date.now() / 1000) {
  const seconds = Math.max(0, Math.round(now - epoch));
  if (seconds < 60) return `${seconds} s ago`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ago`;
  if (seconds < 86400) return `${Math.floor(seconds / 3600)} h ago`;
  return `on ${day(epoch)}`;
}

/** "2 min ago", "Yesterday", "Monday", "12 Nov": when a session was last open. */
export function longAgo(epoch, now = Date.now() / 1000) {
  const minutes = Math.floor((now - epoch) / 60);
  if (minutes < 1) return 'Just now';
  if (minutes < 60) return `${minutes} min ago`;
  const days = daysBetween(epoch, now);
  if (days === 0) return `${Math.floor(minutes / 60)} h ago`;
  if (days === 1) return 'Yesterday';
  if (days < 7) return new Date(epoch * 1000).toLocaleDateString('en-GB', { weekday: 'long' });
  return day(epoch);
}

function day(epoch) {
  const date = new Date(epoch * 1000);
  const year = date.getFullYear() === new Date().getFullYear() ? undefined : 'numeric';
  return date.toLocaleDateString('en-GB', { day: 'numeric', month: 'short', year });
}

function daysBetween(epoch, now) {
  const midnight = (seconds) => new Date(seconds * 1000).setHours(0, 0, 0, 0);
  return Math.round((midnight(now) - midnight(epoch)) / 86400000);
}
