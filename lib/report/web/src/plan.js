// The plan view: the road from above, coloured, with the cursor, findings and control points.
import { css, el, markRange } from './dom.js';
import { drawLegend, scaleOf } from './colour.js';
import { micro, mm, show } from './format.js';
import { onKeys, onTwoFingers, wheelIsFor } from './gestures.js';
import { drawMarks } from './plan_marks.js';
import { saveButtons } from './save.js';

export function makePlan(sheet, windows, surface, data, state) {
  const canvas = el('canvas', { tabindex: 0, role: 'img', 'aria-label': 'Plan view: plus, minus, arrows and 0 zoom and move' });
  const box = el('div', { class: 'canvas plan' }, canvas);
  const legend = el('div', { class: 'legend' });
  const root = el('div', { 'data-view': 'plan' }, box, legend);
  const view = { x: 0, y: 0, scale: 1 };  // map point in the middle, pixels per metre
  let field = sheet.fields.find((f) => f.key === state.field) ?? sheet.fields[0], scale = scaleOf(field);
  let width = 1, height = 1, pending = false;
  const painted = { canvas: document.createElement('canvas'), look: '', scale: null };

  const toScreen = (x, y) => [0.5 * width + (x - view.x) * view.scale, 0.5 * height - (y - view.y) * view.scale];

  function fit() {
    const first = sheet.rowOf(state.range[0]), last = sheet.rowOf(state.range[1]);
    let x0 = Infinity, x1 = -Infinity, y0 = Infinity, y1 = -Infinity;
    for (let k = first * sheet.columns; k < (last + 1) * sheet.columns; ++k) {
      if (Number.isNaN(sheet.z[k])) continue;
      x0 = Math.min(x0, sheet.px[k]); x1 = Math.max(x1, sheet.px[k]);
      y0 = Math.min(y0, sheet.py[k]); y1 = Math.max(y1, sheet.py[k]);
    }
    if (!(x0 <= x1)) { x0 = sheet.x[first] - 10; x1 = sheet.x[first] + 10; y0 = sheet.y[first] - 10; y1 = sheet.y[first] + 10; }
    if (first === 0 && last === sheet.rows - 1) {
      for (const point of data.control_points) {
        x0 = Math.min(x0, point.x_m - data.x_base_m); x1 = Math.max(x1, point.x_m - data.x_base_m);
        y0 = Math.min(y0, point.y_m - data.y_base_m); y1 = Math.max(y1, point.y_m - data.y_base_m);
      }
    }
    view.x = 0.5 * (x0 + x1);
    view.y = 0.5 * (y0 + y1);
    view.scale = 0.9 * Math.min(width / Math.max(5, x1 - x0), height / Math.max(5, y1 - y0));
    markRange(root, state.range[0], state.range[1]);
  }

  /// The window of full detail in the range that is looked at; only heights are known there.
  const windowInView = () => (state.field !== 'elevation' || state.range[1] - state.range[0] > 120 ? null
    : windows.find((w) => w.uBegin < state.range[1] && w.uOf(w.rows - 1) > state.range[0]
      && 0.5 * (state.range[0] + state.range[1]) >= w.uBegin && 0.5 * (state.range[0] + state.range[1]) <= w.uOf(w.rows - 1)) ?? null);

  /// Appends the quads of a grid that are in the picture, of about 1.5 pixels or more: [grid, nodes a, b, c, d] and
  /// their mean heights.
  function quadsOf(grid, without, quads, heights) {
    const rowStride = Math.max(1, Math.round(1.5 / (grid.uStep * view.scale)));
    const vStep = (grid.v[grid.columns - 1] - grid.v[0]) / (grid.columns - 1);
    const columnStride = Math.max(1, Math.round(1.5 / (vStep * view.scale)));
    for (let i = 0; i + 1 < grid.rows; i += rowStride) {
      const next = Math.min(grid.rows - 1, i + rowStride);
      if (without && grid.uOf(i) >= without.uBegin && grid.uOf(next) <= without.uOf(without.rows - 1)) continue;
      const [cx, cy] = toScreen(grid.x[i], grid.y[i]);
      const reach = 40 * view.scale + 20;
      if (cx < -reach || cx > width + reach || cy < -reach || cy > height + reach) continue;
      // From edge to edge of what both rows have: a road of a pixel or two lies between columns that a stride takes.
      const has = (j) => !Number.isNaN(grid.z[i * grid.columns + j] + grid.z[next * grid.columns + j]);
      for (let j = 0, right; j + 1 < grid.columns; j = right) {
        right = j + 1;
        while (right < Math.min(grid.columns - 1, j + columnStride) && has(j) && has(right) && has(right + 1)) ++right;
        const a = i * grid.columns + j, b = i * grid.columns + right, c = next * grid.columns + right, d = next * grid.columns + j;
        const sum = grid.z[a] + grid.z[b] + grid.z[c] + grid.z[d];
        if (Number.isNaN(sum)) continue;
        quads.push([grid, a, b, c, d]);
        heights.push(0.25 * sum + grid.zBase);
      }
    }
  }

  /// The road as it is seen from above: what lies higher is painted later, so that a bridge hides the road below.
  function drawRoad(context) {
    const window = windowInView(), quads = [], heights = [];
    quadsOf(sheet, window, quads, heights);
    if (window) quadsOf(window, null, quads, heights);
    // Millimetres and the index in one number: sorted many times faster than pairs.
    const many = 2 ** 22, order = Float64Array.from(heights, (z, k) => Math.round(1000 * z) * many + k).sort();
    for (const key of order) {
      const [grid, ...corners] = quads[key - Math.floor(key / many) * many];
      const colour = scale.of(grid === sheet ? field.values[corners[0]] : grid.z[corners[0]] + grid.zBase);
      context.fillStyle = colour ? `rgb(${colour[0] | 0},${colour[1] | 0},${colour[2] | 0})` : css_none;
      const x = corners.map((k) => 0.5 * width + (grid.px[k] - view.x) * view.scale), y = corners.map((k) => 0.5 * height - (grid.py[k] - view.y) * view.scale);
      const mx = 0.25 * (x[0] + x[1] + x[2] + x[3]), my = 0.25 * (y[0] + y[1] + y[2] + y[3]);
      context.beginPath();
      for (let c = 0; c < 4; ++c) {
        // A little larger, which hides the seams between quads; a stroke would cost twice as much as the fill.
        const apart = Math.hypot(x[c] - mx, y[c] - my), grow = 1 + 0.9 / Math.max(apart, 0.5);
        context.lineTo(mx + grow * (x[c] - mx), my + grow * (y[c] - my));
      }
      context.closePath();
      context.fill();
    }
  }

  let css_none = '#ccc';

  function draw() {
    pending = false;
    const ratio = window.devicePixelRatio || 1;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = css('--bg');
    context.fillRect(0, 0, width, height);
    css_none = css('--none');
    // The road is painted anew only where it looks otherwise than last time: a cursor moves over what is there.
    const look = [view.x, view.y, view.scale, canvas.width, canvas.height, ratio, css_none, windowInView()?.uBegin, state.field].join();
    if (look !== painted.look || scale !== painted.scale) {
      Object.assign(painted, { look, scale });
      painted.canvas.width = canvas.width;
      painted.canvas.height = canvas.height;
      const road = painted.canvas.getContext('2d');
      road.setTransform(ratio, 0, 0, ratio, 0, 0);
      drawRoad(road);
    }
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(painted.canvas, 0, 0);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    drawMarks(context, { sheet, surface, data, state, toScreen, view, width, height });
  }

  function later() {
    if (pending) return;
    pending = true;
    requestAnimationFrame(draw);
  }

  function resize() {
    width = box.clientWidth || 1;
    height = box.clientHeight || 1;
    if (state.map) showMap(state.map);
    else fit();
  }

  function showMap(map) {
    view.x = map.x;
    view.y = map.y;
    view.scale = width / map.span;
  }

  const inPicture = (k) => {
    const [x, y] = toScreen(sheet.px[k], sheet.py[k]);
    return x >= 0 && x <= width && y >= 0 && y <= height;
  };

  /// What was moved by hand is what a link leads to; colours span what is in the picture once it rests.
  let resting;
  function moved() {
    state.map = { x: view.x, y: view.y, span: width / view.scale };
    later();
    clearTimeout(resting);
    resting = setTimeout(() => { setField(); later(); state.emit('map', 'plan'); }, 200);
  }

  function zoomAt(x, y, factor) {
    const mx = view.x + (x - 0.5 * width) / view.scale, my = view.y - (y - 0.5 * height) / view.scale;
    view.scale = Math.min(2000, Math.max(0.005, view.scale * factor));
    view.x = mx - (x - 0.5 * width) / view.scale;
    view.y = my + (y - 0.5 * height) / view.scale;
    moved();
  }

  function move(dx, dy) {
    view.x -= dx / view.scale;
    view.y += dy / view.scale;
    moved();
  }

  /// {u, v} at a pixel, or null beside the road.
  const pickAt = (x, y) => surface.pick(view.x + (x - 0.5 * width) / view.scale, view.y - (y - 0.5 * height) / view.scale);

  // A mouse drags; one finger scrolls the page and taps, two move and zoom.
  let drag = null;
  canvas.addEventListener('wheel', (event) => {
    if (!wheelIsFor(canvas, event)) return;
    event.preventDefault();
    zoomAt(event.offsetX, event.offsetY, Math.exp(-0.0015 * event.deltaY * (event.ctrlKey ? 4 : 1)));
  }, { passive: false });
  onTwoFingers(canvas, (before, now) => {
    move(now.x - before.x, now.y - before.y);
    zoomAt(now.x, now.y, now.apart / before.apart);
  });
  onKeys(canvas, (wish) => {
    if (wish.reset) state.reset();
    else if (wish.zoom) zoomAt(0.5 * width, 0.5 * height, wish.zoom);
    else move(-60 * wish.dx, 60 * wish.dy);
    return true;
  });
  canvas.addEventListener('dblclick', () => { if (!state.measuring) state.reset(); });
  canvas.addEventListener('pointerdown', (event) => {
    if (event.pointerType === 'touch') return;
    canvas.setPointerCapture(event.pointerId);
    drag = { x: event.offsetX, y: event.offsetY, far: false };
  });
  canvas.addEventListener('pointermove', (event) => {
    if (event.pointerType === 'touch') return;
    if (drag && event.buttons !== 0) {
      if (!drag.far && Math.hypot(event.offsetX - drag.x, event.offsetY - drag.y) < 4) return;
      move(event.offsetX - drag.x, event.offsetY - drag.y);
      drag = { x: event.offsetX, y: event.offsetY, far: true };
      return;
    }
    const point = pickAt(event.offsetX, event.offsetY);
    if (point) { state.setCursor(point.u, 'plan'); return; }
    let best = Infinity, row = 0;
    for (let i = 0; i < sheet.rows; ++i) {
      const [x, y] = toScreen(sheet.x[i], sheet.y[i]);
      const d = (x - event.offsetX) ** 2 + (y - event.offsetY) ** 2;
      if (d < best) { best = d; row = i; }
    }
    if (best < (30 + 12 * view.scale) ** 2) state.setCursor(sheet.uOf(row), 'plan');
  });
  canvas.addEventListener('click', (event) => {
    const dragged = drag?.far;
    drag = null;
    if (dragged) return;
    const point = pickAt(event.offsetX, event.offsetY);
    if (!point) return;
    state.setCursor(point.u, 'plan');
    if (state.measuring) state.setMeasured(state.measured.length === 1 ? [state.measured[0], point] : [point]);
    else state.setPoint(point);
  });

  function setField() {
    field = sheet.fields.find((f) => f.key === state.field) ?? sheet.fields[0];
    let nodes;
    if (state.map) {
      nodes = field.values.filter((value, k) => inPicture(k));
      if (!nodes.some((value) => !Number.isNaN(value))) nodes = undefined;
    }
    scale = nodes ? scaleOf(field, nodes) : scaleOf(field, field.values.subarray(sheet.rowOf(state.range[0]) * sheet.columns, (sheet.rowOf(state.range[1]) + 1) * sheet.columns));
    drawLegend(legend, field, scale, el);
    if ((data.rough?.places.length ?? 0) > 0) {
      const dot = el('i');
      dot.style.background = 'var(--s4)';
      legend.append(dot, `leaves the mesh by more than ${mm(data.rough.limit_m)}`);
    }
    legend.append(save);
  }

  /// The nodes in the picture.
  function table() {
    const rows = [], shown = field.categories.length > 0 ? (value) => field.categories[Math.round(value)] : (value) => value * field.show;
    for (let i = sheet.rowOf(state.range[0]); i <= sheet.rowOf(state.range[1]); ++i) {
      for (let j = 0; j < sheet.columns; ++j) {
        const k = i * sheet.columns + j;
        if (Number.isNaN(sheet.z[k]) || !inPicture(k)) continue;
        const row = [sheet.uOf(i), sheet.v[j], sheet.px[k] + data.x_base_m, sheet.py[k] + data.y_base_m, sheet.z[k] + sheet.zBase].map(micro);
        rows.push(field.key === 'elevation' ? row : [...row, Number.isNaN(field.values[k]) ? null : shown(field.values[k])]);
      }
    }
    const heads = ['u / m', 'v / m', 'x / m', 'y / m', 'z / m'];
    return { heads: field.key === 'elevation' ? heads : [...heads, field.unit ? `${field.name} / ${field.unit}` : field.name], rows };
  }
  const save = saveButtons('plan', () => ({ canvas, title: `${field.name}, ${legend.querySelector('canvas') ? `${show(scale.low * field.show, 3)} to ${show(scale.high * field.show, 3)} ${field.unit}` : ''}`, table }));

  state.subscribe((what, source) => {
    if (what === 'range') { fit(); setField(); }
    if (what === 'map') {
      if (source === 'plan') return;
      showMap(state.map);
      setField();
    }
    if (what === 'field' || what === 'theme') setField();
    if (what === 'print') { resize(); setField(); draw(); return; }
    later();
  });
  // At once: a picture of the size before would be stretched for a frame, or in a print or screenshot for good.
  new ResizeObserver(() => { resize(); if (state.map) setField(); draw(); }).observe(box);
  setField();
  return root;
}
