// A chart of lines as SVG: what is in view, with its axes.
import { css } from './dom.js';
import { tickTexts } from './format.js';

const kTitle_px = 26, kTick_px = { x: 80, y: 18 };  // room for a title; at least that far from tick to tick

/// Multiples of 1, 2 or 5 times a power of ten between two values, with the step; `most` of them at most.
export function niceTicks(low, high, most) {
  const least = (high - low) / Math.max(1, most), power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => each >= least * (1 - 1e-9)), ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) ticks.push(k * step);
  return { ticks, step };
}

/// Pieces of a line without gaps, in pixels: [[x, y], ...] each. Of points that share a fifth of a pixel the first, the lowest, the highest and the last.
export function piecesOf(xs, ys) {
  const pieces = [];
  let piece = [], column = [];
  const flush = () => {
    if (column.length > 4) {
      const of = (better) => column.reduce((best, each, k) => (better(each[1], column[best][1]) ? k : best), 0);
      const kept = [...new Set([0, of((a, b) => a < b), of((a, b) => a > b), column.length - 1])].sort((a, b) => a - b);
      column = kept.map((k) => column[k]);
    }
    piece.push(...column);
    column = [];
  };
  const close = () => { flush(); if (piece.length > 0) pieces.push(piece); piece = []; };
  for (let k = 0; k < xs.length; ++k) {
    if (!Number.isFinite(ys[k]) || ys[k] === null) { close(); continue; }
    if (column.length > 0 && Math.floor(5 * column[0][0]) !== Math.floor(5 * xs[k])) flush();
    column.push([xs[k], ys[k]]);
  }
  close();
  return pieces;
}

/// A uPlot of lines with even scales; `names`: [{name, colour}]. Text stays text.
export function svgOf(plot, title, names) {
  const space = 'http://www.w3.org/2000/svg', ratio = plot.bbox.width / plot.over.clientWidth, box = { x: plot.bbox.left / ratio, y: plot.bbox.top / ratio + kTitle_px, width: plot.bbox.width / ratio, height: plot.bbox.height / ratio };
  const node = (name, attributes, ...children) => {
    const made = document.createElementNS(space, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, typeof value === 'number' ? String(Math.round(100 * value) / 100) : value);
    // XML has no room for control characters.
    made.append(...children.map((child) => (typeof child === 'string' ? child.replace(/[\u0000-\u0008\u000b\u000c\u000e-\u001f\ufffe\uffff]/g, '') : child)));
    return made;
  };
  const width = plot.width, height = plot.height + kTitle_px, muted = css('--muted');
  const x = (value) => box.x + plot.valToPos(value, 'x'), y = (value) => box.y + plot.valToPos(value, 'y');
  const root = node('svg', { xmlns: space, width, height, viewBox: `0 0 ${width} ${height}`, 'font-family': 'system-ui, "DejaVu Sans", sans-serif', 'font-size': 11 },
    node('title', {}, title), node('defs', {}, node('clipPath', { id: 'inside' }, node('rect', box))), node('rect', { width, height, fill: css('--panel') }),
    node('text', { x: 8, y: 17, 'font-size': 13, fill: css('--fg') }, title));
  const legend = node('text', { x: width - 8, y: 17, 'text-anchor': 'end', fill: muted });
  for (const { name, colour } of names) legend.append(node('tspan', { fill: colour, 'font-weight': 'bold', dx: 12 }, '— '), node('tspan', {}, name));
  root.append(legend);
  for (const [key, size] of [['x', box.width], ['y', box.height]]) {
    const { min, max } = plot.scales[key], { ticks, step } = niceTicks(min, max, size / kTick_px[key]);
    tickTexts(ticks, step).forEach((text, k) => {
      const at = key === 'x' ? x(ticks[k]) : y(ticks[k]);
      root.append(node('line', { ...(key === 'x' ? { x1: at, x2: at, y1: box.y, y2: box.y + box.height } : { x1: box.x, x2: box.x + box.width, y1: at, y2: at }), stroke: css('--grid') }),
        node('text', { 'data-tick': key, ...(key === 'x' ? { x: at, y: box.y + box.height + 15, 'text-anchor': 'middle' } : { x: box.x - 6, y: at + 4, 'text-anchor': 'end' }), fill: muted }, text));
    });
    const label = plot.axes[key === 'x' ? 0 : 1]?.label, middle = key === 'x' ? box.x + 0.5 * box.width : box.y + 0.5 * box.height;
    if (label) root.append(node('text', { x: key === 'x' ? middle : 12, y: key === 'x' ? height - 5 : middle, 'text-anchor': 'middle', ...(key === 'y' ? { transform: `rotate(-90 12 ${middle.toFixed(2)})` } : {}), fill: muted }, label));
  }
  const [at, ...columns] = plot.data, { min, max } = plot.scales.x;
  // One beyond each end, so that lines reach the edge.
  const first = Math.max(0, at.findIndex((value) => value >= min) - 1), beyond = at.findIndex((value) => value > max), last = beyond < 0 ? at.length : beyond + 1;
  const xs = Array.from(at.slice(first, last), x), lines = node('g', { 'clip-path': 'url(#inside)', fill: 'none', 'stroke-linejoin': 'round' });
  columns.forEach((column, k) => {
    const series = plot.series[k + 1];
    if (!series.show || !series.stroke) return;
    const ys = Array.from(column.slice(first, last), (value) => (value === null || value === undefined ? null : y(value)));
    for (const piece of piecesOf(xs, ys))
      lines.append(node('polyline', { points: piece.map(([px, py]) => `${px.toFixed(2)},${py.toFixed(2)}`).join(' '), stroke: series.stroke(plot, k + 1), 'stroke-width': series.width, ...(series.dash ? { 'stroke-dasharray': series.dash.join(' ') } : {}) }));
  });
  root.append(lines, node('rect', { ...box, fill: 'none', stroke: css('--line') }));
  return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(root)}\n`;
}
