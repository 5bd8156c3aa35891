// How well what was typed fits a text: whole words best, then beginnings, parts, letters in order, and
// a slip of the finger.

const FITS = { whole: 100, beginning: 85, inside: 55, slip: 35, letters: 30 };
const LEAST_FOR_SLIP = 4;

/** Lower case, without accents, in words. */
const wordsIn = (text) =>
  text.toLowerCase().normalize('NFD').replace(/\p{M}/gu, '').split(/[^\p{L}\p{N}]+/u).filter(Boolean);

/**
 * How well a query fits, 0 where it does not: every word of it must fit one of a field's words.
 * @param {string} query
 * @param {{ text: string, weight: number }[]} fields  The weightiest first.
 */
export function fitOf(query, fields) {
  const wanted = wordsIn(query);
  if (!wanted.length) return 0;
  const known = fields.map(({ text, weight }) => ({ words: wordsIn(text), weight }));
  let sum = 0;
  for (const word of wanted) {
    const best = Math.max(0, ...known.map(({ words, weight }) => weight * Math.max(0, ...words.map((one) => wordFit(word, one)))));
    if (best === 0) return 0;
    sum += best;
  }
  return sum / wanted.length + orderBonus(wanted, known[0].words);
}

/** What begins as the query does, or is no longer than it, stands before what only contains it. */
function orderBonus(wanted, words) {
  const starts = words[0]?.startsWith(wanted[0]) ? 8 : 0;
  const isSame = words.length === wanted.length && words.every((word, i) => word.startsWith(wanted[i]));
  return starts + (isSame ? 8 : 0) - Math.min(6, words.length * 0.5);
}

function wordFit(wanted, word) {
  if (word === wanted) return FITS.whole;
  if (word.startsWith(wanted)) return FITS.beginning;
  if (wanted.length > 1 && word.includes(wanted)) return FITS.inside;
  if (wanted.length >= LEAST_FOR_SLIP && isSlip(wanted, word.slice(0, wanted.length + 1))) return FITS.slip;
  return wanted.length > 1 && wanted[0] === word[0] && isInOrder(wanted, word) ? FITS.letters : 0;
}

function isInOrder(wanted, word) {
  let at = 0;
  for (const letter of word) if (letter === wanted[at]) at += 1;
  return at === wanted.length;
}

/** One letter more, fewer or another, or two swapped; of a beginning of the word. */
function isSlip(wanted, word) {
  return [word, word.slice(0, wanted.length), word.slice(0, wanted.length - 1)].some((each) => isOneOff(wanted, each));
}

function isOneOff(a, b) {
  let start = 0;
  while (start < a.length && a[start] === b[start]) start += 1;
  let end = 0;
  while (end < Math.min(a.length, b.length) - start && a.at(-1 - end) === b.at(-1 - end)) end += 1;
  const [restA, restB] = [a.slice(start, a.length - end), b.slice(start, b.length - end)];
  if (restA.length <= 1 && restB.length <= 1) return true;
  return restA.length === 2 && restB === restA[1] + restA[0];
}
