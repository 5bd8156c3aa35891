// How the state of a segment is shown: the colour of its chip, its icon, and its word.

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
