// The plan view: the road from above, coloured, with the cursor, findings and control points.
import { css, el, markRange } from './dom.js';
import { drawLegend, scaleOf } from './colour.js';

export function makePlan(sheet, windows, data, state) {
  const canvas = el('canvas', { tabindex: 0, 'aria-label': 'Plan view' });
  const box = el('div', { class: 'canvas plan' }, canvas);
  const legend = el('div', { class: 'legend' });
  const root = el('div', { 'data-view': 'plan' }, box, legend);
  const view = { x: 0, y: 0, scale: 1 };  // map point in the middle, pixels per metre
  let field = sheet.fields[0], scale = scaleOf(field);
  let width = 1, height = 1, pending = false;

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

  function drawRoad(context) {
    const window = windowInView();
    drawSheet(context, sheet, field.values, 0, window);
    if (window) drawSheet(context, window, window.z, sheet.zBase, null);
  }

  function drawSheet(context, grid, values, base, without) {
    // Quads of about 1.5 pixels or more; those outside the picture are left out.
    const rowStride = Math.max(1, Math.round(1.5 / (grid.uStep * view.scale)));
    const vStep = (grid.v[grid.columns - 1] - grid.v[0]) / (grid.columns - 1);
    const columnStride = Math.max(1, Math.round(1.5 / (vStep * view.scale)));
    // The stroke hides the seams between quads.
    context.lineWidth = 1.4;
    for (let i = 0; i + 1 < grid.rows; i += rowStride) {
      const next = Math.min(grid.rows - 1, i + rowStride);
      if (without && grid.uOf(i) >= without.uBegin && grid.uOf(next) <= without.uOf(without.rows - 1)) continue;
      const [cx, cy] = toScreen(grid.x[i], grid.y[i]);
      const reach = 40 * view.scale + 20;
      if (cx < -reach || cx > width + reach || cy < -reach || cy > height + reach) continue;
      for (let j = 0; j + 1 < grid.columns; j += columnStride) {
        const right = Math.min(grid.columns - 1, j + columnStride);
        const a = i * grid.columns + j, b = i * grid.columns + right, c = next * grid.columns + right, d = next * grid.columns + j;
        if (Number.isNaN(grid.z[a] + grid.z[b] + grid.z[c] + grid.z[d])) continue;
        const colour = scale.of(values[a] + base);
        context.fillStyle = colour ? `rgb(${colour[0] | 0},${colour[1] | 0},${colour[2] | 0})` : css_none;
        context.beginPath();
        for (const k of [a, b, c, d]) {
          const x = 0.5 * width + (grid.px[k] - view.x) * view.scale, y = 0.5 * height - (grid.py[k] - view.y) * view.scale;
          if (k === a) context.moveTo(x, y); else context.lineTo(x, y);
        }
        context.closePath();
        context.fill();
        context.strokeStyle = context.fillStyle;
        context.stroke();
      }
    }
  }

  let css_none = '#ccc';

  function drawMarks(context) {
    const text = css('--fg'), muted = css('--muted');
    context.font = '12px system-ui, "DejaVu Sans", sans-serif';
    context.textBaseline = 'middle';
    // u at round numbers, about every 90 pixels.
    const span = 90 / view.scale;
    const power = 10 ** Math.floor(Math.log10(span));
    const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= span);
    for (let u = Math.ceil(state.uBegin / step) * step; u <= state.uEnd; u += step) {
      const i = sheet.rowOf(u);
      const [x, y] = toScreen(sheet.px[i * sheet.columns], sheet.py[i * sheet.columns]);
      if (x < -20 || x > width + 20 || y < -20 || y > height + 20) continue;
      const [mx, my] = toScreen(sheet.x[i], sheet.y[i]);
      const length = Math.hypot(x - mx, y - my) || 1;
      context.fillStyle = muted;
      context.textAlign = x > mx ? 'left' : 'right';
      context.fillText(Number(u.toFixed(3)).toString(), x + 7 * (x - mx) / length, y + 7 * (y - my) / length);
    }
    const across = (u, colour, line) => {
      const i = sheet.rowOf(u), a = i * sheet.columns, b = a + sheet.columns - 1;
      const [x0, y0] = toScreen(sheet.px[a], sheet.py[a]), [x1, y1] = toScreen(sheet.px[b], sheet.py[b]);
      context.strokeStyle = colour;
      context.lineWidth = line;
      context.beginPath();
      context.moveTo(x0, y0);
      context.lineTo(x1, y1);
      context.stroke();
      return [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
    };
    const [sx, sy] = across(state.uBegin, text, 2);
    const ahead = Math.min(sheet.rows - 1, 3);
    const heading = Math.atan2(-(sheet.y[ahead] - sheet.y[0]), sheet.x[ahead] - sheet.x[0]);
    context.fillStyle = text;
    context.beginPath();
    context.moveTo(sx + 14 * Math.cos(heading), sy + 14 * Math.sin(heading));
    context.lineTo(sx + 6 * Math.cos(heading + 2.2), sy + 6 * Math.sin(heading + 2.2));
    context.lineTo(sx + 6 * Math.cos(heading - 2.2), sy + 6 * Math.sin(heading - 2.2));
    context.fill();
    for (const finding of data.findings) {
      if (finding.u_end_m - finding.u_begin_m > 0.5 * (state.uEnd - state.uBegin)) continue;
      const i = sheet.rowOf(0.5 * (finding.u_begin_m + finding.u_end_m));
      const v = 0.5 * (finding.v_begin_m + finding.v_end_m);
      const j = Math.max(0, sheet.v.findIndex((w) => w >= v));
      const [x, y] = toScreen(sheet.px[i * sheet.columns + j], sheet.py[i * sheet.columns + j]);
      context.strokeStyle = css(finding.severity === 'error' ? '--bad' : '--warn');
      context.lineWidth = 2.5;
      context.beginPath();
      context.arc(x, y, 7, 0, 2 * Math.PI);
      context.stroke();
    }
    // Where the road leaves its mesh: along the stretch, never shorter than a dot.
    context.strokeStyle = css('--s4');
    context.lineWidth = 4;
    context.lineCap = 'round';
    for (const place of data.rough?.places ?? []) {
      const v = 0.5 * (place.v_min_m + place.v_max_m);
      const j = Math.max(0, sheet.v.findIndex((w) => w >= v));
      context.beginPath();
      for (let i = sheet.rowOf(place.u_begin_m); i <= sheet.rowOf(place.u_end_m); ++i) {
        const [x, y] = toScreen(sheet.px[i * sheet.columns + j], sheet.py[i * sheet.columns + j]);
        context.lineTo(x, y);
        if (i === sheet.rowOf(place.u_begin_m)) context.lineTo(x + 0.1, y);
      }
      context.stroke();
    }
    context.lineCap = 'butt';
    for (const point of data.control_points) {
      const [x, y] = toScreen(point.x_m - data.x_base_m, point.y_m - data.y_base_m);
      context.strokeStyle = text;
      context.lineWidth = 1.5;
      context.beginPath();
      context.moveTo(x - 6, y); context.lineTo(x + 6, y); context.moveTo(x, y - 6); context.lineTo(x, y + 6);
      context.stroke();
      context.fillStyle = text;
      context.textAlign = 'left';
      context.fillText(`${point.name}: ${(1000 * point.residual_m).toFixed(0)} mm`, x + 9, y - 8);
    }
    if (state.cursor !== null) {
      const [x, y] = across(state.cursor, css('--cursor'), 2);
      context.fillStyle = css('--cursor');
      context.beginPath();
      context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fill();
      context.textAlign = 'left';
      context.fillText(`u ${state.cursor.toFixed(1)} m`, x + 10, y - 12);
    }
    // A bar of a round length.
    const barSpan = 120 / view.scale, barPower = 10 ** Math.floor(Math.log10(barSpan));
    const bar = [5, 2, 1].map((k) => k * barPower).find((s) => s <= barSpan);
    context.strokeStyle = text;
    context.fillStyle = text;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(14, height - 14);
    context.lineTo(14 + bar * view.scale, height - 14);
    context.stroke();
    context.textAlign = 'left';
    context.fillText(`${bar} m`, 14, height - 25);
  }

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
    drawRoad(context);
    drawMarks(context);
  }

  function later() {
    if (pending) return;
    pending = true;
    requestAnimationFrame(draw);
  }

  function resize() {
    width = box.clientWidth || 1;
    height = box.clientHeight || 1;
    fit();
  }

  // Drag to pan, wheel or two fingers to zoom, hover for the cursor.
  const pointers = new Map();
  function zoomAt(x, y, factor) {
    const mx = view.x + (x - 0.5 * width) / view.scale, my = view.y - (y - 0.5 * height) / view.scale;
    view.scale = Math.min(2000, Math.max(0.005, view.scale * factor));
    view.x = mx - (x - 0.5 * width) / view.scale;
    view.y = my + (y - 0.5 * height) / view.scale;
    later();
  }
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    zoomAt(event.offsetX, event.offsetY, Math.exp(-0.0015 * event.deltaY));
  }, { passive: false });
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (before) {
      const others = [...pointers.entries()].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      if (others.length > 0) {
        const old = Math.hypot(before[0] - others[0][0], before[1] - others[0][1]);
        const now = Math.hypot(event.offsetX - others[0][0], event.offsetY - others[0][1]);
        if (old > 1) zoomAt(others[0][0], others[0][1], now / old);
      } else {
        view.x -= (event.offsetX - before[0]) / view.scale;
        view.y += (event.offsetY - before[1]) / view.scale;
        later();
      }
      pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
      return;
    }
    let best = Infinity, row = 0;
    for (let i = 0; i < sheet.rows; ++i) {
      const [x, y] = toScreen(sheet.x[i], sheet.y[i]);
      const d = (x - event.offsetX) ** 2 + (y - event.offsetY) ** 2;
      if (d < best) { best = d; row = i; }
    }
    if (best < (30 + 12 * view.scale) ** 2) state.setCursor(sheet.uOf(row), 'plan');
  });
  const release = (event) => pointers.delete(event.pointerId);
  canvas.addEventListener('pointerup', release);
  canvas.addEventListener('pointercancel', release);

  function setField() {
    field = sheet.fields.find((f) => f.key === state.field) ?? sheet.fields[0];
    scale = scaleOf(field, sheet.rowOf(state.range[0]) * sheet.columns, (sheet.rowOf(state.range[1]) + 1) * sheet.columns);
    drawLegend(legend, field, scale, el);
    if ((data.rough?.places.length ?? 0) > 0) {
      const dot = el('i');
      dot.style.background = 'var(--s4)';
      legend.append(dot, `leaves the mesh by more than ${(1000 * data.rough.limit_m).toFixed(0)} mm`);
    }
  }

  state.subscribe((what) => {
    if (what === 'range') { fit(); setField(); }
    if (what === 'field' || what === 'theme') setField();
    if (what === 'print') { resize(); setField(); draw(); return; }
    later();
  });
  new ResizeObserver(() => { resize(); later(); }).observe(box);
  setField();
  return root;
}
