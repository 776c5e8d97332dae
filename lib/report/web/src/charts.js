// Curves along u and small plots, drawn by uPlot.
import uPlot from 'uplot';
import { css, el, markRange } from './dom.js';
import { show, tickTexts } from './format.js';
import { onKeys, onTwoFingers } from './gestures.js';
import { saveButtons } from './save.js';
import { svgOf } from './svg.js';

const all = [];

const font = '11px system-ui, "DejaVu Sans", sans-serif';

function axis(label, size) {
  return {
    label, labelSize: label ? 18 : 0, size, font, labelFont: font,
    stroke: () => css('--muted'), grid: { stroke: () => css('--grid'), width: 1 }, ticks: { stroke: () => css('--line'), width: 1, size: 4 },
    values: (plot, splits, which, space, step) => tickTexts(splits, step),
  };
}

export function plainAxes(xLabel, yLabel) {
  const y = axis(yLabel, 56);
  // Wider where the numbers are long.
  y.size = (plot, texts) => Math.max(48, 14 + 6.5 * (texts ?? []).reduce((most, text) => Math.max(most, (text ?? '').length), 0));
  return [axis(xLabel, 36), y];
}

export function line(label, colour, options = {}) {
  return { label, stroke: () => css(colour), width: 1.4, points: { show: false }, value: (plot, value) => show(value, 5), ...options };
}

/// The numbers of a chart in view: what its columns are called and its rows, those without any value left out.
function tableOf(plot, heads) {
  const { min, max } = plot.scales.x, [x, ...columns] = plot.data, rows = [];
  for (let k = 0; k < x.length; ++k) {
    if (x[k] < min || x[k] > max || columns.every((column) => column[k] === null || column[k] === undefined)) continue;
    rows.push([x[k], ...columns.map((column) => column[k])]);
  }
  return { heads, rows };
}

/// A plot that fills its box and follows the theme. `about`: view (what it is to tests and in names of files),
/// title, heads (of its table), range() and setRange(low, high) where it does not own what it shows of x, and
/// table(plot) where its numbers are not those of its lines.
export function makeChart(options, rows, height, about) {
  const box = el('div', { class: 'chart', tabindex: 0, role: 'group', 'aria-label': `${about.title}: plus, minus, arrows and 0 zoom and move`, 'data-view': about.view });
  const chart = { box, plot: null, rows };
  const log = options.scales?.x?.distr === 3;
  const there = (x) => (log ? Math.log(x) : x), back = (x) => (log ? Math.exp(x) : x);
  const whole = () => [chart.rows[0][0], chart.rows[0][chart.rows[0].length - 1]];
  const range = about.range ?? (() => [chart.plot.scales.x.min, chart.plot.scales.x.max]);
  const setRange = about.setRange ?? ((low, high) => {
    const [first, last] = whole();
    low = Math.max(first, low);
    high = Math.min(last, high);
    if (there(high) - there(low) > 1e-4 * (there(last) - there(first))) chart.plot.setScale('x', { min: low, max: high });
  });
  /// Shows the stretch that lies `factor` closer around x, then moved by `shift` of its own width.
  const zoom = (x, factor, shift) => {
    const [low, high] = range().map(there), middle = there(x), width = (high - low) / factor;
    const begin = middle - (middle - low) / factor + shift * width;
    setRange(back(begin), back(begin + width));
  };
  const reset = about.reset ?? (() => setRange(...whole()));
  const middle = () => { const [low, high] = range().map(there); return back(0.5 * (low + high)); };
  onKeys(box, (wish) => {
    if (!chart.plot || wish.dy) return false;
    if (wish.reset) reset();
    else if (wish.zoom) zoom(about.centre?.() ?? middle(), wish.zoom, 0);
    else zoom(middle(), 1, 0.25 * wish.dx);
    return true;
  });
  const tall = () => (document.documentElement.dataset.printing ? Math.round(0.55 * height) : height);
  const fit = (width) => {
    if (width < 10 || (Math.abs(chart.plot.width - width) <= 1 && chart.plot.height === tall())) return false;
    chart.plot.setSize({ width, height: tall() });
    return true;
  };
  const build = () => {
    const width = Math.max(120, Math.floor(box.clientWidth || 600));
    const plot = new uPlot({ width, height: tall(), ...options }, chart.rows, (self, init) => { box.prepend(self.root); init(); });
    plot.over.addEventListener('dblclick', (event) => { event.stopImmediatePropagation(); reset(); }, true);
    onTwoFingers(plot.over, (before, now) => {
      const pixels = plot.over.clientWidth || 1;
      zoom(plot.posToVal(before.x, 'x'), now.apart / before.apart, (before.x - now.x) / pixels);
    });
    return plot;
  };
  const observer = new ResizeObserver(() => {
    const width = Math.floor(box.clientWidth);
    if (width < 10) return;
    if (!chart.plot) chart.plot = build();
    else fit(width);
  });
  observer.observe(box);
  chart.refresh = () => {
    if (!chart.plot) return;
    // uPlot gives the legend its colours once.
    const names = [...chart.plot.root.querySelectorAll('.u-series')], first = options.series.length - names.length;
    names.forEach((name, k) => {
      const marker = name.querySelector('.u-marker'), colour = options.series[first + k]?.stroke?.();
      if (marker && colour) marker.style.borderColor = colour;
    });
    if (!fit(Math.floor(box.clientWidth))) chart.plot.redraw(false, true);
  };
  chart.setRows = (next) => {
    chart.rows = next;
    chart.plot?.setData(next);
  };
  const names = () => (about.names?.() ?? options.series.slice(1)).filter((series) => series.label && series.stroke).map((series) => ({ name: series.label, colour: series.stroke() }));
  // What a chart paints by itself over its lines, bars, and uneven scales are in its picture alone.
  const isLines = !options.hooks?.draw && !log && options.series.every((series) => !series.paths);
  box.append(saveButtons(about.view, () => ({
    canvas: chart.plot?.ctx.canvas, title: about.title, names: names(),
    table: () => (about.table ? about.table(chart.plot) : tableOf(chart.plot, about.heads ?? options.series.map((series) => series.label ?? ''))),
    svg: () => (chart.plot ? svgOf(chart.plot, about.title ?? '', names()) : ''),
  }), isLines));
  if (options.legend?.show === false) box.classList.add('bare');
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
export function makeLinkedChart(state, options, rows, height, about) {
  const name = about.view;
  let quiet = false, started = false;
  // The same for all, so that a place lies below itself.
  options.axes[1].size = 64;
  const chart = makeChart({
    ...options,
    cursor: { drag: { x: true, y: false, uni: 20 }, points: { size: 6 }, y: false, ...(options.cursor ?? {}) },
    scales: { x: { time: false, range: (plot, low, high) => (low === null || !started ? [...state.range] : [low, high]) }, ...(options.scales ?? {}) },
    hooks: {
      ...(options.hooks ?? {}),
      drawClear: [placeBand(state), ...(options.hooks?.drawClear ?? [])],
      ready: [() => { started = true; }],
      setScale: [(plot, key) => {
        if (key !== 'x') return;
        const { min, max } = plot.scales.x;
        if (min === null || min === undefined) return;
        markRange(chart.box, min, max);
        if (!quiet) state.setRange(min, max, name);
      }, ...(options.hooks?.setScale ?? [])],
      setCursor: [(plot) => {
        if (quiet || plot.cursor.left === null || plot.cursor.left < 0) return;
        if (!plot.over.matches(':hover')) return;
        state.setCursor(plot.posToVal(plot.cursor.left, 'x'), name);
      }],
    },
  }, rows, height, {
    range: () => state.range, setRange: (low, high) => state.moveTo(low, high), reset: () => state.reset(), centre: () => state.centre(), ...about,
  });
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

/// Lines over v: a cut across the road. `view` tells plots of the page apart.
export function makeCrossPlot(cross, view, height = 170) {
  const colours = { file: '--s1', mesh: '--s2', against: '--s3', cloud: '--s2', before: '--s4' };
  // Over the lowest height in the cut: absolute heights have too many digits to read.
  const known = cross.lines.flatMap((l) => l.z_m).filter((z) => z !== null);
  const base = known.length > 0 ? known.reduce((a, b) => Math.min(a, b)) : 0;
  const rows = [cross.at_v_m, ...cross.lines.map((l) => l.z_m.map((z) => (z === null ? null : 1000 * (z - base))))];
  return makeChart({
    axes: plainAxes('v / m', 'z / mm'),
    scales: { x: { time: false } },
    legend: { show: true, live: false },
    cursor: { drag: { x: true, y: false } },
    series: [{ label: 'v / m' }, ...cross.lines.map((l, k) => line(l.name, colours[l.name] ?? '--s4', {
      width: k === 0 ? 2 : 1.6, dash: k === 0 ? undefined : [5, 3],
    }))],
  }, rows, height, {
    view, title: cross.title,
    table: (plot) => {
      const { min, max } = plot.scales.x, kept = cross.at_v_m.map((v, k) => k).filter((k) => cross.at_v_m[k] >= min && cross.at_v_m[k] <= max);
      return { heads: ['v / m', ...cross.lines.map((l) => `${l.name}: z / m`)], rows: kept.map((k) => [cross.at_v_m[k], ...cross.lines.map((l) => l.z_m[k])]) };
    },
  }).box;
}

export { uPlot };
