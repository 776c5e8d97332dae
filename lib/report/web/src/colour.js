// Colours of numbers. Sequential: viridis (CC0) by nine stops; signed: blue, neutral, red.
import { css } from './dom.js';
import { show } from './format.js';

const viridis = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];
const category = [[120, 128, 136], [46, 134, 222], [242, 153, 74], [39, 174, 96], [155, 89, 182], [235, 87, 87]];

function mix(stops, t) {
  const at = Math.min(0.999999, Math.max(0, t)) * (stops.length - 1);
  const k = Math.floor(at), f = at - k;
  return stops[k].map((c, i) => c + f * (stops[k + 1][i] - c));
}

function rgbOf(hex) {
  const value = parseInt(hex.slice(1), 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

/// Limits that a few extreme values do not stretch.
export function limitsOf(values, signed) {
  const sample = [];
  const step = Math.max(1, Math.floor(values.length / 20000));
  for (let k = 0; k < values.length; k += step) if (!Number.isNaN(values[k])) sample.push(values[k]);
  if (sample.length === 0) return [0, 1];
  sample.sort((a, b) => a - b);
  let low = sample[Math.floor(0.005 * (sample.length - 1))], high = sample[Math.ceil(0.995 * (sample.length - 1))];
  if (signed) {
    const reach = Math.max(Math.abs(low), Math.abs(high), 1e-9);
    return [-reach, reach];
  }
  if (!(high - low > 1e-9)) { low -= 0.5; high += 0.5; }
  return [low, high];
}

/// A function from a value to [r, g, b] (0..255); NaN gets null. The limits are those of `values`: of what is
/// looked at, so that colours tell something about that place.
export function scaleOf(field, values = field.values) {
  if (field.categories.length > 0) {
    const of = (value) => (Number.isNaN(value) ? null : category[Math.round(value) % category.length]);
    return { of, low: 0, high: field.categories.length - 1 };
  }
  const [low, high] = limitsOf(values, field.signed);
  const stops = field.signed ? [[33, 82, 176], [120, 166, 226], rgbOf(css('--mid')), [232, 140, 110], [176, 32, 38]] : viridis;
  return { of: (value) => (Number.isNaN(value) ? null : mix(stops, (value - low) / (high - low))), low, high };
}

export function drawLegend(node, field, scale, el) {
  node.replaceChildren();
  if (field.categories.length > 0) {
    field.categories.forEach((name, k) => {
      const swatch = el('i');
      swatch.style.background = `rgb(${scale.of(k).join(',')})`;
      node.append(swatch, name);
    });
    return;
  }
  const canvas = el('canvas', { width: 180, height: 12 });
  const context = canvas.getContext('2d');
  for (let x = 0; x < 180; ++x) {
    context.fillStyle = `rgb(${scale.of(scale.low + (x / 179) * (scale.high - scale.low)).map(Math.round).join(',')})`;
    context.fillRect(x, 0, 1, 12);
  }
  node.append(show(scale.low * field.show, 3), canvas, `${show(scale.high * field.show, 3)} ${field.unit}`);
}
