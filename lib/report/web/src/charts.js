// Curves along u and small plots, drawn by uPlot.
import uPlot from 'uplot';
import { css, el, markRange } from './dom.js';

const all = [];

function axis(label, size) {
  return {
    label, labelSize: label ? 18 : 0, size, font: '11px system-ui, "DejaVu Sans", sans-serif',
    labelFont: '11px system-ui, "DejaVu Sans", sans-serif',
    stroke: () => css('--muted'), grid: { stroke: () => css('--grid'), width: 1 }, ticks: { stroke: () => css('--line'), width: 1, size: 4 },
  };
}

export function plainAxes(xLabel, yLabel) {
  return [axis(xLabel, 36), axis(yLabel, 56)];
}

const digits = (value) => (value === null || value === undefined ? '–' : Number(value.toPrecision(5)).toString());

export function line(label, colour, options = {}) {
  return { label, stroke: () => css(colour), width: 1.4, points: { show: false }, value: (plot, value) => digits(value), ...options };
}

/// A plot that fills its box and follows the theme.
export function makeChart(options, rows, height, attributes = {}) {
  const box = el('div', { class: 'chart', ...attributes });
  const build = () => {
    const width = Math.max(120, Math.floor(box.clientWidth || 600));
    return new uPlot({ width, height, ...options }, rows, box);
  };
  const chart = { box, plot: null };
  const observer = new ResizeObserver(() => {
    const width = Math.floor(box.clientWidth);
    if (width < 10) return;
    if (!chart.plot) chart.plot = build();
    else if (Math.abs(chart.plot.width - width) > 1) chart.plot.setSize({ width, height });
  });
  observer.observe(box);
  chart.refresh = () => {
    if (!chart.plot) return;
    const width = Math.floor(box.clientWidth);
    if (width > 10 && Math.abs(chart.plot.width - width) > 1) chart.plot.setSize({ width, height });
    else chart.plot.redraw(false, true);
  };
  all.push(chart);
  return chart;
}

export function refreshCharts() {
  for (const chart of all) chart.refresh();
}

/// The range of a finding, behind the curves.
function placeBand(state) {
  return (plot) => {
    if (!state.place) return;
    const x0 = plot.valToPos(state.place[0], 'x', true), x1 = plot.valToPos(state.place[1], 'x', true);
    const context = plot.ctx, ratio = window.devicePixelRatio || 1;
    context.save();
    context.beginPath();
    context.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
    context.clip();
    context.fillStyle = css('--mark');
    context.fillRect(x0 - 2 * ratio, plot.bbox.top, x1 - x0 + 4 * ratio, plot.bbox.height);
    context.restore();
  };
}

/// A chart over u that zooms and points together with all other views.
export function makeLinkedChart(state, options, rows, height, name) {
  let quiet = false;
  const chart = makeChart({
    ...options,
    cursor: { drag: { x: true, y: false, uni: 20 }, points: { size: 6 }, y: false, ...(options.cursor ?? {}) },
    scales: { x: { time: false, range: (plot, low, high) => (low === null ? [...state.range] : [low, high]) }, ...(options.scales ?? {}) },
    hooks: {
      ...(options.hooks ?? {}),
      drawClear: [placeBand(state), ...(options.hooks?.drawClear ?? [])],
      ready: [(plot) => { quiet = true; plot.setScale('x', { min: state.range[0], max: state.range[1] }); quiet = false; }],
      setScale: [(plot, key) => {
        if (key !== 'x') return;
        const { min, max } = plot.scales.x;
        if (min === null || min === undefined) return;
        markRange(chart.box, min, max);
        if (!quiet) state.setRange(min, max, name);
      }],
      setCursor: [(plot) => {
        if (quiet || plot.cursor.left === null || plot.cursor.left < 0) return;
        if (!plot.over.matches(':hover')) return;
        state.setCursor(plot.posToVal(plot.cursor.left, 'x'), name);
      }],
      init: [(plot) => {
        plot.over.addEventListener('dblclick', (event) => { event.stopImmediatePropagation(); state.reset(); }, true);
      }],
    },
  }, rows, height, { 'data-view': name });
  markRange(chart.box, state.range[0], state.range[1]);
  state.subscribe((what, source) => {
    const plot = chart.plot;
    if (!plot) return;
    if (what === 'range') {
      quiet = true;
      plot.setScale('x', { min: state.range[0], max: state.range[1] });
      quiet = false;
    } else if (what === 'cursor' && source !== name && state.cursor !== null) {
      quiet = true;
      plot.setCursor({ left: plot.valToPos(state.cursor, 'x'), top: 8 }, false);
      quiet = false;
    } else if (what === 'place') plot.redraw(false, false);
  });
  return chart.box;
}

/// Lines over v: a cut across the road.
export function makeCrossPlot(cross, height = 170) {
  const colours = { file: '--s1', mesh: '--s2', against: '--s3', cloud: '--s2', before: '--s4' };
  const rows = [cross.at_v_m, ...cross.lines.map((l) => l.z_m)];
  // Over the lowest height in the cut: absolute heights have too many digits to read.
  const known = cross.lines.flatMap((l) => l.z_m).filter((z) => z !== null);
  const base = known.length > 0 ? known.reduce((a, b) => Math.min(a, b)) : 0;
  const relative = rows.map((row, k) => (k === 0 ? row : row.map((z) => (z === null ? null : 1000 * (z - base)))));
  return makeChart({
    axes: plainAxes('v / m', 'z / mm'),
    scales: { x: { time: false } },
    legend: { show: true, live: false },
    cursor: { drag: { x: false, y: false } },
    series: [{ label: 'v / m' }, ...cross.lines.map((l, k) => line(l.name, colours[l.name] ?? '--s4', {
      width: k === 0 ? 2 : 1.6, dash: k === 0 ? undefined : [5, 3],
    }))],
  }, relative, height).box;
}

export { uPlot };
