// Two roads over one another: heights side by side with a border to be moved, and the difference as a map.
import { css, el } from '../../../report/web/src/dom.js';
import { mm, show } from '../../../report/web/src/format.js';
import { getPacked } from './server.js';

const kRelief_m = 0.12;  // heights about the middle of each row that are told apart
const kLeast_m = 0.0005;  // a difference that is worth a colour

/// The largest |difference| with its place, and what all but 2 % stay below; null: nothing is shared.
export function differenceOf(packed) {
  const { rows, columns } = packed.head, all = [];
  let largest = null;
  for (let k = 0; k < rows * columns; ++k) {
    const d = packed.z_m[k] - packed.against_m[k];
    if (Number.isNaN(d)) continue;
    all.push(Math.abs(d));
    if (!largest || Math.abs(d) > Math.abs(largest.d)) largest = { d, u: packed.u_m[Math.floor(k / columns)], v: packed.v_m[k % columns] };
  }
  if (!largest) return null;
  all.sort((a, b) => a - b);
  return { largest, usual: all[Math.floor(0.98 * (all.length - 1))], compared: all.length, same: all.filter((d) => d < kLeast_m).length };
}

const rgb = (colour) => { const n = parseInt(colour.slice(1), 16); return [n >> 16, (n >> 8) & 255, n & 255]; };
const mix = (a, b, t) => a.map((value, k) => Math.round(value + (b[k] - value) * t));

/// `kept()`: another stretch was chosen.
export function makeCompare(kept = () => {}) {
  let packed = null, told = null, at = null;
  const begin = el('input', { type: 'number', step: 'any', 'aria-label': 'Compare from u / m', 'data-role': 'u-begin' });
  const end = el('input', { type: 'number', step: 'any', 'aria-label': 'to u / m', 'data-role': 'u-end' });
  const mode = el('select', { 'aria-label': 'How two roads are compared', 'data-role': 'compare-mode' }, el('option', { value: 'difference' }, 'difference'), el('option', { value: 'swipe' }, 'swipe'));
  const slider = el('input', { type: 'range', min: 0, max: 100, value: 50, 'aria-label': 'Border between this road (left) and the other (right)', 'data-role': 'swipe' });
  const canvas = el('canvas', { tabindex: 0, role: 'application', 'aria-label': 'Heights along the stretch, u to the right, v upwards; arrows move the place that is read' });
  const words = el('p', { class: 'small', role: 'status', 'data-role': 'difference' }), reading = el('p', { class: 'small muted', 'data-role': 'reading' });
  const root = el('div', { class: 'panel compare', hidden: '' }, el('div', { class: 'tools' }, el('label', {}, 'u from', begin), el('label', {}, 'to', end), el('label', {}, 'as', mode), slider), words, el('div', { class: 'canvas heights' }, canvas), reading);
  let asked = ['', ''];

  function colourOf() {
    const { columns, rows } = packed.head, none = rgb('#8d949c'), limit = Math.max(kLeast_m, told?.usual ?? 0, 0.1 * Math.abs(told?.largest.d ?? 0));
    if (mode.value === 'difference') return (k) => {
      const d = packed.z_m[k] - packed.against_m[k];
      if (Number.isNaN(packed.z_m[k]) && Number.isNaN(packed.against_m[k])) return null;
      if (Number.isNaN(d)) return none;
      return mix([244, 244, 244], d > 0 ? [178, 24, 43] : [33, 102, 172], Math.min(1, Math.abs(d) / limit));
    };
    const border = (slider.valueAsNumber / 100) * rows;
    const middle = Array.from({ length: rows }, (_, i) => {
      const row = Array.from(packed.z_m.slice(i * columns, (i + 1) * columns)).filter((z) => !Number.isNaN(z)).sort((a, b) => a - b);
      return row[Math.floor(row.length / 2)] ?? 0;
    });
    return (k) => {
      const i = Math.floor(k / columns), z = (i < border ? packed.z_m : packed.against_m)[k];
      return Number.isNaN(z) ? null : mix([30, 40, 56], [252, 244, 220], Math.min(1, Math.max(0, 0.5 + (z - middle[i]) / (2 * kRelief_m))));
    };
  }

  function draw() {
    const context = canvas.getContext('2d');
    canvas.width = Math.max(1, canvas.clientWidth);
    canvas.height = Math.max(1, canvas.clientHeight);
    slider.hidden = mode.value !== 'swipe';
    if (!packed) return;
    const { rows, columns } = packed.head, colour = colourOf(), image = context.createImageData(canvas.width, canvas.height);
    const low = packed.v_m[0], high = packed.v_m[columns - 1];
    const columnAt = Array.from({ length: canvas.height }, (_, y) => {
      const v = high - ((high - low) * y) / Math.max(1, canvas.height - 1);
      let j = packed.v_m.findIndex((each) => each >= v);
      if (j < 0) j = columns - 1;
      return j > 0 && v - packed.v_m[j - 1] < packed.v_m[j] - v ? j - 1 : j;
    });
    for (let x = 0; x < canvas.width; ++x) {
      const i = Math.min(rows - 1, Math.floor((x * rows) / canvas.width));
      for (let y = 0; y < canvas.height; ++y) {
        const of = colour(i * columns + columnAt[y]), to = 4 * (y * canvas.width + x);
        if (of) [image.data[to], image.data[to + 1], image.data[to + 2], image.data[to + 3]] = [...of, 255];
      }
    }
    context.putImageData(image, 0, 0);
    context.fillStyle = css('--cursor');
    if (mode.value === 'swipe') context.fillRect(Math.round((slider.valueAsNumber / 100) * canvas.width) - 1, 0, 2, canvas.height);
    if (at) {
      context.fillRect(Math.round(((at[0] + 0.5) * canvas.width) / rows), 0, 1, canvas.height);
      context.fillRect(0, columnAt.findIndex((j) => j === at[1]), canvas.width, 1);
    }
  }

  function read() {
    const k = at[0] * packed.head.columns + at[1], z = packed.z_m[k], other = packed.against_m[k];
    const height = (value) => (Number.isNaN(value) ? 'no road' : `${value.toFixed(3)} m`);
    reading.textContent = `u ${packed.u_m[at[0]].toFixed(1)} m, v ${packed.v_m[at[1]].toFixed(2)} m: ${height(z)}, the other ${height(other)}${Number.isNaN(z - other) ? '' : `, difference ${mm(z - other)}`}`;
    draw();
  }
  canvas.addEventListener('pointermove', (event) => {
    if (!packed) return;
    const { rows, columns } = packed.head, v = packed.v_m[columns - 1] - ((packed.v_m[columns - 1] - packed.v_m[0]) * event.offsetY) / canvas.clientHeight;
    let j = packed.v_m.findIndex((each) => each >= v);
    if (j < 0) j = columns - 1;
    at = [Math.min(rows - 1, Math.max(0, Math.floor((event.offsetX * rows) / canvas.clientWidth))), j];
    read();
  });
  canvas.addEventListener('keydown', (event) => {
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (!packed || !(event.key in moves)) return;
    const { rows, columns } = packed.head, step = event.shiftKey ? 10 : 1;
    at ??= [rows >> 1, columns >> 1];
    at = [rows, columns].map((count, k) => Math.min(count - 1, Math.max(0, at[k] + step * moves[event.key][k])));
    read();
    event.preventDefault();
  });
  mode.addEventListener('change', draw);
  slider.addEventListener('input', draw);
  new ResizeObserver(draw).observe(canvas);

  async function load() {
    const [id, against] = asked;
    delete root.dataset.compared;
    root.hidden = !against;
    packed = null;
    at = null;
    if (!against) return;
    words.textContent = 'Comparing …';
    try {
      const next = await getPacked('difference', { id, against, u_begin: Number.isFinite(begin.valueAsNumber) ? begin.valueAsNumber : -1e9, u_end: Number.isFinite(end.valueAsNumber) ? end.valueAsNumber : 1e9 });
      if (asked[0] !== id || asked[1] !== against) return;
      packed = next;
      told = differenceOf(packed);
      words.textContent = told === null ? 'The two have no place in common.'
        : told.usual < kLeast_m && Math.abs(told.largest.d) < kLeast_m ? `Nothing differs by half a millimetre at ${told.compared} places.`
          : `The largest difference: ${mm(told.largest.d)} at u ${show(told.largest.u, 6, 1)} m, v ${show(told.largest.v, 4, 2)} m; ${show(100 * (1 - told.same / told.compared), 3)} % of ${told.compared} places differ by half a millimetre or more. Red: this road is higher, blue: the other; grey: one of them has no height.`;
      root.dataset.compared = `${id} ${against}`;
      reading.textContent = '';
    } catch (error) {
      words.textContent = error.message;
    }
    draw();
  }
  for (const each of [begin, end]) each.addEventListener('change', () => { load(); kept(); });

  return {
    root,
    /// [u from, u to] as they are typed; '': the end of the road.
    stretch: () => [begin.value, end.value],
    /// `stretch`: [u from, u to] as text; '' for an end of the road.
    show(id, against, stretch = ['', '']) {
      asked = [id, against];
      [begin.value, end.value] = stretch;
      return load();
    },
  };
}
