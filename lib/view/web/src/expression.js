// Arithmetic with channels: 3.6 * vx_mps, hypot(ax_mps2, ay_mps2) / 9.81, [Ground Speed] - d([Distance]).

const functions = {
  abs: [1, Math.abs], sqrt: [1, Math.sqrt], sin: [1, Math.sin], cos: [1, Math.cos], tan: [1, Math.tan], exp: [1, Math.exp], log: [1, Math.log],
  atan2: [2, Math.atan2], hypot: [2, Math.hypot], min: [2, Math.min], max: [2, Math.max],
};
const operators = { '+': (a, b) => a + b, '-': (a, b) => a - b, '*': (a, b) => a * b, '/': (a, b) => a / b, '^': (a, b) => a ** b };
const kDeepest = 50, kLongest = 2000;

/// Numbers, names, names in brackets, signs; each with the place where it stands.
function wordsOf(text) {
  const pattern = /\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|\[([^\]]+)\]|([A-Za-z_][\w.]*)|([-+*/^(),]))/y, words = [];
  while (pattern.lastIndex < text.trimEnd().length) {
    const at = pattern.lastIndex, found = pattern.exec(text);
    if (!found) throw new Error(`'${text.slice(at).trim().slice(0, 12)}' is not understood; wanted are numbers, channels ([in brackets] where they have blanks), + - * / ^ ( ) and ${Object.keys(functions).join(', ')}, d (per second)`);
    const [, number, quoted, name, sign] = found;
    words.push(number !== undefined ? { number: Number(number) } : quoted !== undefined ? { channel: quoted } : name !== undefined ? { name } : { sign });
  }
  return words;
}

/// {channels: the names it needs, of(columns, time): its values}. `columns`: name -> numbers; `time`: in seconds, for d(). Throws where it is no expression.
export function expressionOf(text) {
  if (text.length > kLongest) throw new Error(`an expression of ${text.length} characters; at most ${kLongest} are read`);
  const words = wordsOf(text), channels = new Set();
  let at = 0, depth = 0;
  const sign = (wanted) => words[at]?.sign === wanted && ++at > 0;
  const need = (wanted) => { if (!sign(wanted)) throw new Error(`'${wanted}' is missing ${at < words.length ? `before '${shownOf(words[at])}'` : 'at the end'}`); };
  const shownOf = (word) => word.sign ?? word.name ?? word.channel ?? word.number;
  const channel = (name) => { channels.add(name); return (row) => row.columns[name][row.k]; };

  function call(name) {
    if (name === 'd') {
      const of = sum();
      need(')');
      // Between the samples before and behind; of an end, to its neighbour.
      return (row) => {
        const before = Math.max(0, row.k - 1), behind = Math.min(row.time.length - 1, row.k + 1), at_k = (k) => of({ ...row, k });
        return (at_k(behind) - at_k(before)) / (row.time[behind] - row.time[before]);
      };
    }
    const known = Object.hasOwn(functions, name) ? functions[name] : null;
    if (!known) throw new Error(`there is no function '${name}'; there are ${Object.keys(functions).join(', ')}, d`);
    const values = [sum()];
    while (sign(',')) values.push(sum());
    need(')');
    if (values.length !== known[0]) throw new Error(`${name} takes ${known[0]} value${known[0] > 1 ? 's' : ''}, ${values.length} seen`);
    return (row) => known[1](...values.map((value) => value(row)));
  }
  function value() {
    const word = words[at];
    if (!word) throw new Error('it ends where a value is wanted');
    ++at;
    if (word.number !== undefined) return () => word.number;
    if (word.channel !== undefined) return channel(word.channel);
    if (word.name !== undefined) return sign('(') ? call(word.name) : channel(word.name);
    if (word.sign !== '(') throw new Error(`'${word.sign}' where a value is wanted`);
    const inside = sum();
    need(')');
    return inside;
  }
  function power() {
    const base = value();
    if (!sign('^')) return base;
    const exponent = signed();  // 2^3^2 is 2^(3^2)
    return (row) => base(row) ** exponent(row);
  }
  function signed() {
    if (++depth > kDeepest) throw new Error(`more than ${kDeepest} levels of brackets and signs`);
    const minus = sign('-'), plus = !minus && sign('+'), of = minus || plus ? signed() : power();
    --depth;
    return minus ? (row) => -of(row) : of;
  }
  function chain(next, signs) {
    let left = next();
    while (words[at] && signs.includes(words[at].sign)) {
      const apply = operators[words[at++].sign], a = left, b = next();
      left = (row) => apply(a(row), b(row));
    }
    return left;
  }
  const product = () => chain(signed, ['*', '/']);
  function sum() { return chain(product, ['+', '-']); }

  const whole = sum();
  if (at < words.length) throw new Error(`'${shownOf(words[at])}' where an operator is wanted`);
  return { channels: [...channels], of: (columns, time) => Float64Array.from(time, (_, k) => whole({ columns, time, k })) };
}
