// Numbers as a person reads them: every number of the page goes through here. None shows "-0", an exponent
// where a plain number will do, or digits that mean nothing.

/// At most `digits` significant digits and `decimals` decimals, without trailing zeros; a dash for no value.
export function show(value, digits = 4, decimals = 6) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const places = Math.min(decimals, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value)))));
  const rounded = Number(value.toFixed(places));
  return rounded === 0 ? '0' : String(rounded);
}

/// Exactly `decimals` decimals.
export function fixed(value, decimals) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace('-', '') : text;
}

/// Metres as millimetres with two decimals, as the tools print them; three where two would hide the number.
export function mm(value) {
  const text = show(value === null || value === undefined ? value : 1000 * value, 9, Math.abs(value) < 1e-4 ? 3 : 2);
  return text === '–' ? text : `${text} mm`;
}

export const count = (value) => value.toLocaleString('en');

export const metres = (value) => fixed(value, 1);

/// To a millionth, for tables of metres: what a float32 has beyond is noise.
export const micro = (value) => Math.round(1e6 * value) / 1e6 || 0;

/// As many decimals as multiples of `step` need to differ.
function decimalsOf(step) {
  for (let decimals = 0; decimals < 15; ++decimals) {
    const scaled = step * 10 ** decimals;
    if (scaled > 0.5 && Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled) return decimals;
  }
  return 15;
}

/// The labels of an axis whose ticks are `step` apart: no two alike.
export function tickTexts(values, step) {
  const decimals = decimalsOf(step);
  return values.map((value) => {
    if (value === null || value === undefined) return '';
    const multiple = Math.round(value / step);
    if (multiple === 0 && Math.abs(value) < 1e-6 * step) return '0';
    if (decimals <= 6 && Math.abs(value) < 1e9) return Number(value.toFixed(decimals)) === 0 ? '0' : String(Number(value.toFixed(decimals)));
    return Number((multiple * step).toPrecision(9)).toExponential().replace('e+', 'e');
  });
}
