// Changes of a recipe's text that leave everything else in it as it is, comments too.

const quoted = (word) => `'${word.replaceAll("'", "''")}'`;

/// As YAML takes it: in quotes where it would be something else.
const scalar = (word) => (/^[A-Za-z0-9/._][A-Za-z0-9/._ -]*$/.test(word) && !/\s$/.test(word) ? word : quoted(word));

const lineOf = (key) => new RegExp(`^${key}[ \\t]*:.*$`, 'm');

/// The value's text; undefined where the recipe does not say.
export function valueOf(text, key) {
  const found = text.match(new RegExp(`^${key}[ \\t]*:[ \\t]*(.*?)[ \\t]*(?:[ \\t]#.*)?$`, 'm'));
  return found ? found[1].replace(/^'(.*)'$/, '$1').replace(/^"(.*)"$/, '$1') : undefined;
}

/// The recipe with this key; null takes it away. What follows a # on its line stays.
export function withValue(text, key, value) {
  const line = lineOf(key);
  if (value === null) return text.replace(new RegExp(`^${key}[ \\t]*:.*\\n?`, 'm'), '');
  const old = text.match(line)?.[0];
  const comment = old?.match(/[ \t]+#.*$/)?.[0] ?? '';
  const now = `${key}: ${value}${comment}`;
  if (old !== undefined) return text.replace(line, () => now);
  return `${text}${text === '' || text.endsWith('\n') ? '' : '\n'}${now}\n`;
}

export const withPath = (text, key, path) => withValue(text, key, path === null ? null : scalar(path));

export const withPoint = (text, key, point) => withValue(text, key, `[${point.map((value) => Number(value.toFixed(3))).join(', ')}]`);

export const withRoute = (text, points) => withValue(text, 'route', points.length < 2 ? null
  : points.map((point) => point.map((value) => Number(value.toFixed(3))).join(',')).join(' '));

/// The recipe with a rule in front of the others: what is called exactly so is of this class.
export function withRule(text, field, name, surfaceClass) {
  const pattern = `^${name.replace(/[.*+?^${}()|[\]\\/]/g, '\\$&')}$`;
  const rule = `  - {${field}: ${quoted(pattern)}, class: ${surfaceClass}}`;
  const others = text.split('\n').filter((line) => !line.startsWith(`  - {${field}: ${quoted(pattern)}, class:`)).join('\n');
  const head = others.match(/^name_rules[ \t]*:(.*)$/m);
  if (!head) return `${others}${others === '' || others.endsWith('\n') ? '' : '\n'}name_rules:\n${rule}\n`;
  if (!/^[ \t]*(#.*)?$/.test(head[1])) throw new Error('the name_rules of this recipe stand in one line; write them one rule a line, each after "  - "');
  return others.replace(/^name_rules[ \t]*:.*$/m, (line) => `${line}\n${rule}`);
}
