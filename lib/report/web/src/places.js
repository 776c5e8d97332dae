// What one asks of single places: a cut across the road anywhere, and the way from one point to another.
import { css, el, table } from './dom.js';
import { line, makeChart, plainAxes } from './charts.js';
import { fixed, metres, show } from './format.js';

/// The number that was typed, with a point or a comma; NaN for anything else.
export function typed(text) {
  const plain = text.trim().replace(',', '.').replace(/\s*m$/, '');
  return /^[+-]?(\d+\.?\d*|\.\d+)$/.test(plain) ? Number(plain) : NaN;
}

export function numberBox(label, attributes = {}) {
  return el('input', { type: 'text', inputmode: 'decimal', autocomplete: 'off', size: 7, 'aria-label': label, ...attributes });
}

/// Marks a box whose text is no number between low and high, and says so to whoever reads it.
export function accept(box, low, high) {
  const value = typed(box.value), good = value >= low && value <= high;
  box.setAttribute('aria-invalid', String(!good));
  box.setCustomValidity(good ? '' : `a number from ${metres(low)} to ${metres(high)}`);
  if (!good) box.reportValidity();
  return good ? value : NaN;
}

const where = (point) => `u ${fixed(point.u, 2)} m, v ${fixed(point.v, 2)} m`;

export function makeCut(surface, data, state) {
  const v = data.sheet.v_m, uBox = numberBox('u of the cross section / m', { 'data-role': 'cut-u' }), vBox = numberBox('v of the cross section / m', { 'data-role': 'cut-v' });
  const form = el('form', { class: 'tools' }, el('label', {}, 'u', uBox, 'm'), el('label', {}, 'v', vBox, 'm'), el('button', { type: 'submit' }, 'Cut'));
  const text = el('p', { 'data-role': 'cut-text' });
  let cut = { u: 0, v: [0, 1], z: [null, null], step: 0 };
  const chart = makeChart({
    axes: plainAxes('v / m', 'z / mm over the lowest'),
    scales: { x: { time: false } },
    legend: { show: false },
    cursor: { drag: { x: true, y: false } },
    series: [{ label: 'v / m' }, line('z', '--s1', { width: 2 })],
    hooks: {
      drawClear: [(plot) => {
        if (!state.point) return;
        const x = plot.valToPos(state.point.v, 'x', true);
        plot.ctx.fillStyle = css('--cursor');
        plot.ctx.fillRect(x - 1, plot.bbox.top, 2, plot.bbox.height);
      }],
    },
  }, [[0, 1], [null, null]], 200, {
    view: 'cut-plot', title: 'Cross section', names: () => [{ label: `u ${fixed(cut.u, 2)} m`, stroke: () => css('--s1') }],
    table: (plot) => {
      const { min, max } = plot.scales.x;
      return { heads: ['u / m', 'v / m', 'z / m'], rows: cut.v.map((at, k) => [cut.u, at, cut.z[k]]).filter(([, at]) => at >= min && at <= max) };
    },
  });
  const update = () => {
    const { point } = state;
    chart.box.hidden = point === null;
    root.classList.toggle('no-print', point === null);
    if (!point) {
      text.textContent = 'Click the road on the plan, or type u and v.';
      return;
    }
    uBox.value = fixed(point.u, 2);
    vBox.value = fixed(point.v, 2);
    cut = surface.cutAt(point.u);
    // From border to border of what has heights.
    const first = cut.z.findIndex((z) => z !== null);
    if (first >= 0) {
      let last = cut.z.length - 1;
      while (cut.z[last] === null) --last;
      cut = { ...cut, v: cut.v.slice(first, last + 1), z: cut.z.slice(first, last + 1) };
    }
    const known = cut.z.filter((z) => z !== null), base = known.reduce((a, b) => Math.min(a, b), Infinity);
    chart.setRows([cut.v, cut.z.map((z) => (z === null ? null : 1000 * (z - base)))]);
    const z = surface.heightAt(point.u, point.v), [x, y] = surface.positionAt(point.u, point.v);
    text.textContent = `At ${where(point)}: ${Number.isNaN(z) ? 'no height' : `z ${fixed(z, 3)} m`}, x ${fixed(x + data.x_base_m, 2)} m, y ${fixed(y + data.y_base_m, 2)} m. `
      + `The line is the row of heights at u ${fixed(cut.u, 2)} m; here the page has one every ${fixed(cut.step, 2)} m.`;
  };
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    if (vBox.value.trim() === '') vBox.value = '0';
    const at = accept(uBox, state.uBegin, state.uEnd), across = accept(vBox, v[0], v[v.length - 1]);
    if (Number.isNaN(at) || Number.isNaN(across)) return;
    state.setPoint({ u: at, v: across });
    if (at < state.range[0] || at > state.range[1]) state.goTo(at, at);
    else state.setCursor(at, 'cut');
  });
  const root = el('div', { 'data-view': 'cut' }, el('h3', {}, 'Cross section'), form, text, chart.box);
  state.subscribe((what) => { if (what === 'point') update(); });
  update();
  return root;
}

export function makeMeasure(surface, data, state) {
  const v = data.sheet.v_m;
  const boxes = ['first', 'second'].map((name) => [numberBox(`u of the ${name} point / m`, { 'data-role': `${name}-u` }), numberBox(`v of the ${name} point / m`, { 'data-role': `${name}-v` })]);
  const form = el('form', { class: 'tools' }, boxes.map(([u, across], k) => el('span', { class: 'pair' }, k === 0 ? 'from' : 'to', el('label', {}, 'u', u), el('label', {}, 'v', across), 'm')),
    el('button', { type: 'submit' }, 'Measure'), el('button', { type: 'button', 'data-role': 'forget', onclick: () => { boxes.flat().forEach((box) => { box.value = ''; }); state.setMeasured([]); } }, 'Clear'));
  const result = el('div', { 'data-role': 'measured' });
  const update = () => {
    const [a, b] = state.measured;
    root.classList.toggle('no-print', !b);
    state.measured.forEach((point, k) => { boxes[k][0].value = fixed(point.u, 2); boxes[k][1].value = fixed(point.v, 2); });
    if (!b) {
      result.replaceChildren(el('p', {}, a ? `From ${where(a)}. Now the second point.` : 'Turn "Measure" on above the plan and click two points, or type them.'));
      return;
    }
    const [p, q] = [a, b].map((point) => [...surface.positionAt(point.u, point.v), surface.heightAt(point.u, point.v)]);
    const plan = Math.hypot(q[0] - p[0], q[1] - p[1]), rise = q[2] - p[2], du = b.u - a.u, length = state.uEnd - state.uBegin;
    const round = data.closed && Math.abs(du) > 0.5 * length ? `, ${fixed(du - Math.sign(du) * length, 2)} m over the seam` : '';
    const number = (text) => ({ number: text }), without = 'no height there';
    result.replaceChildren(table(null, [
      ['Plan distance', number(`${fixed(plan, 3)} m`)],
      ['Height difference', number(Number.isNaN(rise) ? without : `${fixed(rise, 3)} m`)],
      ['Distance in space', number(Number.isNaN(rise) ? without : `${fixed(Math.hypot(plan, rise), 3)} m`)],
      ['Slope', number(Number.isNaN(rise) || plan < 1e-3 ? '–' : `${show((100 * rise) / plan, 3, 2)} %`)],
      ['du', number(`${fixed(du, 2)} m${round}`)],
      ['dv', number(`${fixed(b.v - a.v, 2)} m`)],
    ]));
  };
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const points = boxes.map(([u, across]) => ({ u: accept(u, state.uBegin, state.uEnd), v: accept(across, v[0], v[v.length - 1]) }));
    if (points.every((point) => !Number.isNaN(point.u + point.v))) state.setMeasured(points);
  });
  const root = el('div', { 'data-view': 'measure' }, el('h3', {}, 'From point to point'), form, result);
  state.subscribe((what) => { if (what === 'measured') update(); });
  update();
  return root;
}
