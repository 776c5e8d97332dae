// What stands on the plan view's road: distances, start, findings, control points, cursor, what is measured, a scale.
import { css } from './dom.js';
import { metres, mm, show } from './format.js';

/// `picture`: the sheet, surface, data and state of the page, `toScreen` from map to pixels, `view` with its pixels per
/// metre, `width` and `height` in pixels.
export function drawMarks(context, picture) {
  const { sheet, data, state, toScreen, view, width, height } = picture;
  const text = css('--fg'), muted = css('--muted');
  context.font = '12px system-ui, "DejaVu Sans", sans-serif';
  context.textBaseline = 'middle';
  // Readable on road of any colour, too.
  const write = (words, x, y) => {
    const { strokeStyle, lineWidth } = context;
    context.strokeStyle = css('--bg');
    context.lineWidth = 3;
    context.lineJoin = 'round';
    context.strokeText(words, x, y);
    context.strokeStyle = strokeStyle;
    context.lineWidth = lineWidth;
    context.fillText(words, x, y);
  };
  // u at round numbers, about every 90 pixels.
  const span = 90 / view.scale;
  const power = 10 ** Math.floor(Math.log10(span));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= span);
  const taken = [];
  for (let u = Math.ceil(state.uBegin / step) * step; u <= state.uEnd; u += step) {
    const i = sheet.rowOf(u);
    const j = Math.max(0, sheet.v.findIndex((v, k) => !Number.isNaN(sheet.z[i * sheet.columns + k])));
    const [x, y] = toScreen(sheet.px[i * sheet.columns + j], sheet.py[i * sheet.columns + j]);
    if (x < -20 || x > width + 20 || y < -20 || y > height + 20) continue;
    const [mx, my] = toScreen(sheet.x[i], sheet.y[i]);
    const length = Math.hypot(x - mx, y - my) || 1;
    context.fillStyle = muted;
    context.textAlign = x > mx ? 'left' : 'right';
    const label = show(u, 7, 3), at = [x + 7 * (x - mx) / length, y + 7 * (y - my) / length];
    // Where stretches meet only the first one's label is readable.
    if (taken.some(([px, py]) => Math.abs(px - at[0]) < 8 * label.length && Math.abs(py - at[1]) < 14)) continue;
    taken.push(at);
    write(label, ...at);
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
    write(`${point.name}: ${mm(point.residual_m)}${point.left_out ? ', left out' : ''}`, x + 9, y - 8);
  }
  if (state.cursor !== null) {
    const [x, y] = across(state.cursor, css('--cursor'), 2);
    context.fillStyle = css('--cursor');
    context.beginPath();
    context.arc(x, y, 4, 0, 2 * Math.PI);
    context.fill();
    context.textAlign = 'left';
    write(`u ${metres(state.cursor)} m`, x + 10, y - 12);
  }
  drawPicked(context, picture);
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
  write(`${bar} m`, 14, height - 25);
}

/// Where the cross section lies, and what is measured.
function drawPicked(context, { sheet, surface, state, toScreen }) {
  const spot = (point) => toScreen(...surface.positionAt(point.u, point.v));
  const dot = ([x, y], colour) => {
    context.fillStyle = colour;
    context.strokeStyle = css('--panel');
    context.lineWidth = 1.5;
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  };
  if (state.point) {
    const { u, v } = state.point, [x0, y0] = spot({ u, v: sheet.v[0] }), [x1, y1] = spot({ u, v: sheet.v[sheet.columns - 1] });
    context.strokeStyle = css('--accent');
    context.lineWidth = 1.5;
    context.setLineDash([5, 4]);
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.stroke();
    context.setLineDash([]);
    dot(spot({ u, v }), css('--accent'));
  }
  if (state.measured.length === 2) {
    context.strokeStyle = css('--bad');
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(...spot(state.measured[0]));
    context.lineTo(...spot(state.measured[1]));
    context.stroke();
  }
  for (const point of state.measured) dot(spot(point), css('--bad'));
}
