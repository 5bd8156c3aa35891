// What a person types into a number field: `96`, `1,5`, `30/2`, `+5` and `-=5` (from where it
// stands), `*2`, `1.78 m` in a field of centimetres. Refusals are one sentence.

const LENGTHS = { m: 1, cm: 0.01, mm: 0.001 };
const SIGNS = { '−': '-', '–': '-', '×': '*', '·': '*', '÷': '/' };

/** The number meant by `text` in a field that shows `value`: {value} or {words}. */
export function read(text, value, unit = '') {
  const plain = [...text.trim()]
    .map((c) => SIGNS[c] ?? c)
    .join('')
    .replace(/(\d),(\d)/g, '$1.$2');
  if (plain === '') return { words: 'A number is missing.' };
  const [expression, factor] = inUnit(plain, unit);
  // A leading minus is a negative number; `-=5` takes five away.
  const relative = /^(?:([-+*/])=|([+*/]))(.*)$/.exec(expression);
  const result = evaluate(relative ? relative[3] : expression);
  if (result === null) return { words: `“${text.trim()}” is not a number.` };
  const amount = result * factor;
  const answer = relative ? applyRelative(relative[1] ?? relative[2], value, amount, result) : amount;
  if (!Number.isFinite(answer)) return { words: 'Cannot divide by zero.' };
  return { value: answer };
}

/** A number as the page writes it: a true minus sign, never "−0.0". */
export function shortNumber(value, decimals) {
  const text = value.toFixed(decimals);
  const zero = /^-0(\.0*)?$/.test(text);
  return (zero ? text.slice(1) : text).replace('-', '−');
}

/** The same with its sign: "+1.5", "−0.3". */
export const signedNumber = (value, decimals) => (value < 0 ? '' : '+') + shortNumber(value, decimals);

/** The value within low and high; low where they cross. */
export const clamp = (value, low, high) => Math.max(low, Math.min(high, value));

function applyRelative(sign, value, amount, ratio) {
  if (sign === '+') return value + amount;
  if (sign === '-') return value - amount;
  return sign === '*' ? value * ratio : value / ratio;
}

/** Cuts a unit off the end; another length than the field's own is converted. */
function inUnit(text, unit) {
  const found = /^(.*?)\s*(mm|cm|m|px|°|deg|%)$/.exec(text);
  if (!found) return [text, 1];
  const factor = found[2] in LENGTHS && unit in LENGTHS ? LENGTHS[found[2]] / LENGTHS[unit] : 1;
  return [found[1], factor];
}

/** + − × ÷ and brackets, without handing the text to the browser; null when it is no sum. */
function evaluate(text) {
  const tokens = text.match(/\d+\.?\d*(?:e[-+]?\d+)?|\.\d+|[-+*/()]|\S/gi) ?? [];
  let place = 0;
  const sum = () => chain(product, '+', '-');
  const product = () => chain(single, '*', '/');
  function chain(part, more, less) {
    let total = part();
    while (tokens[place] === more || tokens[place] === less) {
      total = combine(tokens[place++], total, part());
    }
    return total;
  }
  function single() {
    const token = tokens[place++];
    if (token === '-') return -single();
    if (token === '+') return single();
    if (token !== '(') return token !== undefined && /^[\d.]/.test(token) ? Number(token) : NaN;
    const inner = sum();
    return tokens[place++] === ')' ? inner : NaN;
  }
  const total = sum();
  return place === tokens.length && !Number.isNaN(total) ? total : null;
}

function combine(sign, a, b) {
  if (sign === '+') return a + b;
  if (sign === '-') return a - b;
  return sign === '*' ? a * b : a / b;
}
