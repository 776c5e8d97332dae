// The sections of the report below the track itself.
import { css, el, placeButton, table } from './dom.js';
import { unpackCurve, unpackRows, unpackWithout, withGaps } from './data.js';
import { line, makeChart, makeCrossPlot, makeLinkedChart, plainAxes, uPlot } from './charts.js';
import { count, fixed, metres, mm, show } from './format.js';

const widened = (low, high, least) => (high - low >= least ? [low, high] : [0.5 * (low + high - least), 0.5 * (low + high + least)]);

export function alongU(data, state) {
  const root = el('div', { class: 'panel curves' });
  const byKey = Object.fromEntries(data.curves.map((curve) => [curve.key, curve]));
  const values = Object.fromEntries(data.curves.map((curve) => [curve.key, withGaps(unpackCurve(curve.values), curve.show_factor)]));
  if (values.banking) {
    byKey.banking_deg = { name: 'Banking' };
    values.banking_deg = values.banking.map((value) => (value === null ? null : Math.atan(value / 100) * 180 / Math.PI));
  }
  const count = data.curves.length > 0 ? values[data.curves[0].key].length : 0;
  const u = Array.from({ length: count }, (_, k) => data.u_begin_m + k * data.u_step_m);
  const colours = ['--s1', '--s2', '--s3', '--s4'];
  const add = (name, keys, unit, height = 150) => {
    const known = keys.filter((key) => byKey[key]);
    if (known.length === 0) return;
    const title = `${known.length === 1 ? byKey[known[0]].name : name} / ${unit}`;
    root.append(el('div', {}, el('h3', {}, title),
      makeLinkedChart(state, {
        axes: plainAxes('', ''),
        // Never so near that a scale shows the noise of computing: a micrometre, or what is as little.
        scales: { y: { range: (plot, low, high) => (low === null ? [0, 1] : uPlot.rangeNum(...widened(low, high, unit.startsWith('1/m') ? 1e-5 : 1e-3), 0.1, true)) } },
        series: [line('u / m', '--muted'), ...known.map((key, k) => line(byKey[key].name, colours[k % colours.length]))],
      }, [u, ...known.map((key) => values[key])], height, {
        view: `curve-${known[0]}`, title, heads: ['u / m', ...known.map((key) => `${byKey[key].name} / ${unit}`)],
      })));
  };
  add('Elevation', ['elevation_m'], 'm', 170);
  add('Slope', ['slope'], '%');
  add('Vertical curvature', ['vertical_curvature_1pm'], '1/m');
  add('Banking', ['banking'], '%');
  add('Banking', ['banking_deg'], '°');
  add('Heading', ['heading_rad'], '°');
  add('Curvature', ['curvature_1pm'], '1/m');
  add('Curvature rate', ['curvature_rate_1pm2'], '1/m²');
  add('Width and limits', ['width_m', 'v_left_m', 'v_right_m'], 'm', 170);
  add('Largest error in each row', data.curves.map((curve) => curve.key).filter((key) => key.startsWith('largest_error')), 'mm');
  // What a trajectory's drift was, lap by lap (lidar2mesh).
  for (const [of, unit] of [['x_m', 'mm'], ['y_m', 'mm'], ['z_m', 'mm'], ['roll_rad', 'mrad'], ['pitch_rad', 'mrad'], ['yaw_rad', 'mrad']])
    add(`Drift taken out of ${of.split('_')[0]}`, data.curves.map((curve) => curve.key).filter((key) => key.startsWith(`drift_${of}`)), unit, 120);
  root.append(el('p', { class: 'muted small no-print' }, 'Drag across a curve to zoom all views, double click for the whole road. With a finger: two zoom and move, one scrolls the page.'));
  return root;
}

/// Where the road closes: both ends side by side.
export function seam(data, state) {
  if (!data.closed) return el('p', { class: 'muted' }, 'The road is open: there is no seam.');
  const found = data.findings.filter((finding) => finding.kind === 'wrong_seam');
  return el('p', {}, found.length === 0 ? 'Seam: the road closes without a step in height, heading or place beyond the limits. '
    : `Seam: ${found.map((finding) => finding.text).join('. ')}. `,
  placeButton(state, data.u_end_m - 2, data.u_end_m), ' ', placeButton(state, data.u_begin_m, data.u_begin_m + 2));
}

/// Errors as colours over u and v. The colours, as the curves, span what is in view.
function heatMap(comparison, places, state) {
  const map = comparison.map;
  const columns = map.v_m.length;
  const error = unpackRows(map.error, columns);
  const without = unpackWithout(map.error);
  const picture = el('canvas');
  const v0 = map.v_m[0], v1 = map.v_m[columns - 1], half = columns > 1 ? 0.5 * (map.v_m[1] - v0) : 0.5;
  const uEnd = map.u_begin_m + map.rows * map.u_cell_m;
  const below = 'rgb(30,80,190)', above = 'rgb(190,30,40)', none = 'rgb(225,190,60)';
  const lowText = el('span', { 'data-role': 'below' }), highText = el('span', { 'data-role': 'above' });
  let first = 0, last = 0, limit = 0, drawn = '';

  /// 1.5 times the 95th percentile of the rows in view: a few cells must not wash out all others.
  function limitInView() {
    const step = Math.max(1, Math.floor(((last - first) * columns) / 60000)), sizes = [];
    for (let k = first * columns; k < last * columns; k += step) if (!Number.isNaN(error[k])) sizes.push(Math.abs(error[k]));
    if (sizes.length === 0) return 1e-6;
    const sorted = Float32Array.from(sizes).sort(), at = (share) => sorted[Math.floor(share * (sorted.length - 1))];
    return Math.max(1e-6, 1.5 * at(0.95), 0.2 * at(0.99));
  }

  function paint(low, high, pixels) {
    first = Math.max(0, Math.floor((low - map.u_begin_m) / map.u_cell_m));
    last = Math.min(map.rows, Math.max(first + 1, Math.ceil((high - map.u_begin_m) / map.u_cell_m)));
    const mid = css('--mid'), now = `${first} ${last} ${pixels} ${mid}`;
    if (now === drawn) return;
    drawn = now;
    limit = limitInView();
    lowText.textContent = `${mm(limit)} below`;
    highText.textContent = `${mm(limit)} above`;
    // No finer than the screen; each pixel shows the largest error of its rows.
    const stride = Math.ceil((last - first) / pixels), width = Math.ceil((last - first) / stride);
    picture.width = width;
    picture.height = columns;
    const context = picture.getContext('2d');
    const image = context.createImageData(width, columns);
    const neutral = [1, 3, 5].map((k) => parseInt(mid.slice(k, k + 2), 16)), red = [190, 30, 40], blue = [30, 80, 190], gold = [225, 190, 60];
    for (let x = 0; x < width; ++x) {
      for (let j = 0; j < columns; ++j) {
        let worst = NaN, bare = false;
        for (let i = first + x * stride; i < Math.min(last, first + (x + 1) * stride); ++i) {
          const value = error[i * columns + j];
          bare = bare || without[i * columns + j] === 1;
          if (!(Math.abs(value) <= Math.abs(worst))) worst = Number.isNaN(value) ? worst : value;
        }
        const at = 4 * ((columns - 1 - j) * width + x);
        if (Number.isNaN(worst) && !bare) continue;
        const to = Number.isNaN(worst) ? gold : worst > 0 ? red : blue, t = Number.isNaN(worst) ? 1 : Math.min(1, Math.abs(worst) / limit);
        for (let c = 0; c < 3; ++c) image.data[at + c] = neutral[c] + t * (to[c] - neutral[c]);
        image.data[at + 3] = 255;
      }
    }
    context.putImageData(image, 0, 0);
  }

  const chart = makeLinkedChart(state, {
    axes: plainAxes('u / m', 'v / m'),
    legend: { show: false },
    scales: { y: { range: () => [v0 - half, v1 + half] } },
    series: [{ label: 'u / m' }, { label: 'v / m', points: { show: false }, width: 0 }],
    hooks: {
      draw: [(plot) => {
        paint(plot.scales.x.min, plot.scales.x.max, Math.max(1, Math.ceil(plot.bbox.width)));
        const x0 = plot.valToPos(map.u_begin_m + first * map.u_cell_m, 'x', true), x1 = plot.valToPos(map.u_begin_m + last * map.u_cell_m, 'x', true);
        const y0 = plot.valToPos(v1 + half, 'y', true), y1 = plot.valToPos(v0 - half, 'y', true);
        const context = plot.ctx;
        context.save();
        context.beginPath();
        context.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
        context.clip();
        context.imageSmoothingEnabled = x1 - x0 < 2 * picture.width;
        context.drawImage(picture, x0, y0, x1 - x0, y1 - y0);
        // Frames around the stretches that leave the mesh, large enough to be seen.
        context.strokeStyle = css('--s4');
        context.lineWidth = 1.5 * (window.devicePixelRatio || 1);
        const least = 3 * context.lineWidth;
        for (const place of places) {
          const u0 = plot.valToPos(place.u_begin_m, 'x', true), u1 = plot.valToPos(place.u_end_m, 'x', true);
          const top = plot.valToPos(place.v_max_m, 'y', true), bottom = plot.valToPos(place.v_min_m, 'y', true);
          context.strokeRect(u0 - least, top - least, u1 - u0 + 2 * least, bottom - top + 2 * least);
        }
        context.restore();
      }],
    },
  }, [[map.u_begin_m, uEnd], [v0, v1]], 220, {
    view: `heat-${comparison.key}`, title: `Error over u and v (${comparison.key})`,
    names: () => [[`${mm(limit)} below`, below], [`${mm(limit)} above`, above]].map(([label, colour]) => ({ label, stroke: () => colour })),
    table: () => {
      const rows = [];
      for (let i = first; i < last; ++i) {
        for (let j = 0; j < columns; ++j) {
          const k = i * columns + j, bare = without[k] === 1;
          if (bare || !Number.isNaN(error[k])) rows.push([map.u_begin_m + (i + 0.5) * map.u_cell_m, map.v_m[j], bare ? null : 1000 * error[k], bare ? 1 : 0]);
        }
      }
      return { heads: ['u / m', 'v / m', 'error / mm', 'nothing to compare with'], rows };
    },
  });
  const swatch = (colour, text) => {
    const box = el('i');
    box.style.background = colour;
    return [box, text];
  };
  const legend = el('div', { class: 'legend' },
    swatch(below, lowText), swatch('var(--mid)', 'equal'), swatch(above, highText),
    swatch(none, 'nothing within reach to compare with'),
    places.length > 0 ? swatch('var(--s4)', 'framed: named below') : null);
  return [chart, legend];
}

/// Where the road leaves its mesh: how much of it and why, and every stretch, the largest first.
function roughPlaces(data, state) {
  const { limit_m: limit, places } = data.rough;
  const root = el('div', { 'data-view': 'rough' }, el('h3', {}, `Where the road leaves the mesh by more than ${mm(limit)}`));
  if (places.length === 0) {
    root.append(el('p', {}, 'Nowhere that was looked at: the middle of every cell of the rows 0.5 m apart, and every cell where the heights bend.'));
    return root;
  }
  const reasons = [...new Set(places.map((place) => place.reason))].map((reason) => {
    const some = places.filter((place) => place.reason === reason);
    return [reason, some, some.reduce((sum, place) => sum + place.u_end_m - place.u_begin_m, 0)];
  }).sort((a, b) => b[1].length - a[1].length);
  root.append(table(['why', { number: 'places' }, { number: 'length along u' }, { number: 'largest error' }], reasons.map(([reason, some, length]) => [
    reason, { number: some.length }, { number: `${metres(length)} m` }, { number: mm(Math.max(...some.map((place) => place.largest_error_m))) }])));
  const sorted = [...places].sort((a, b) => b.largest_error_m - a.largest_error_m);
  const row = (place) => el('tr', {}, el('td', {}, placeButton(state, place.u_begin_m, place.u_end_m)),
    el('td', { class: 'number' }, `v ${fixed(place.v_min_m, 2)}${place.v_max_m - place.v_min_m < 0.05 ? '' : ` … ${fixed(place.v_max_m, 2)}`} m`),
    el('td', { class: 'number' }, mm(place.largest_error_m)), el('td', { class: 'text' }, place.reason));
  const body = el('tbody', {}, sorted.slice(0, 12).map(row));
  root.append(el('div', { class: 'scroll' }, el('table', { class: 'findings rough' }, el('thead', {}, el('tr', {},
    el('th', {}, 'place'), el('th', { class: 'number' }, 'across'), el('th', { class: 'number' }, 'largest error'), el('th', {}, 'why'))), body)));
  if (sorted.length > 12) {
    const more = el('button', { type: 'button', onclick: () => { more.remove(); body.append(...sorted.slice(12).map(row)); } }, `Show the other ${sorted.length - 12} places`);
    root.append(more);
  }
  return root;
}

function histogram(comparison) {
  const { begin_m: begin, step_m: step, counts } = comparison.histogram;
  const total = counts.reduce((a, b) => a + b, 0) || 1;
  // Millimetres, or what their thousandths are called where all lies within a few of them.
  const [unit, factor] = Math.abs(begin) < 5e-6 ? ['µm', 1e6] : ['mm', 1000];
  return makeChart({
    axes: plainAxes(`error / ${unit} (outer bars: all beyond)`, 'share / %'),
    legend: { show: false },
    cursor: { drag: { x: true, y: false } },
    scales: { x: { time: false } },
    series: [{ label: `error / ${unit}` }, { label: 'share / %', stroke: () => css('--s1'), fill: () => css('--s1'), width: 0, paths: uPlot.paths.bars({ size: [0.9] }), points: { show: false } }],
  }, [counts.map((_, k) => factor * (begin + (k + 0.5) * step)), counts.map((n) => (100 * n) / total)], 220, {
    view: `histogram-${comparison.key}`, title: `Distribution of the error (${comparison.key})`, names: () => [],
  }).box;
}

export function errors(data, state) {
  const titles = { mesh: 'Against the mesh', against: 'Against another road file', cloud: 'Against the cloud', before: 'Before and after refinement' };
  if (data.comparisons.length === 0) {
    return [el('div', { class: 'panel', 'data-view': 'errors' }, el('p', { class: 'muted' },
      'Nothing to compare with was given: neither the mesh, nor another road file, nor the road before refinement.'))];
  }
  return data.comparisons.map((comparison) => el('div', { class: 'panel', 'data-view': 'errors' },
    el('h3', {}, (titles[comparison.key] ?? comparison.key) + (comparison.reference ? `: ${comparison.reference}` : '')),
    table(['points', 'p50', 'p95', 'p99', 'max', 'mean', 'nothing to compare with'].map((number) => ({ number })), [[
      count(comparison.points), mm(comparison.abs_error_m.p50), mm(comparison.abs_error_m.p95), mm(comparison.abs_error_m.p99),
      mm(comparison.abs_error_m.max), mm(comparison.mean_m), `${fixed(100 * comparison.share_without_reference, 3)} %`,
    ].map((number) => ({ number }))]),
    el('h3', {}, 'Error over u and v'), heatMap(comparison, comparison.key === 'mesh' && data.rough ? data.rough.places : [], state),
    comparison.key === 'mesh' && data.rough ? roughPlaces(data, state) : null,
    el('div', { class: 'two no-print' },
      el('div', {}, el('h3', {}, 'Distribution'), histogram(comparison)),
      el('div', {}, el('h3', {}, 'Worst places'), table(['place', { number: 'error' }], comparison.worst.map((cut) => [
        placeButton(state, cut.u_m, cut.u_m), { number: mm(cut.value_m) }])))),
    el('h3', { class: 'no-print' }, 'Cuts through the worst places'),
    el('div', { class: 'cards no-print' }, comparison.worst.map((cut, k) => el('div', { class: 'card', 'data-view': 'worst' },
      el('div', { class: 'head' }, el('span', {}, cut.title), placeButton(state, cut.u_m, cut.u_m)), makeCrossPlot(cut, `worst-${comparison.key}-${k + 1}`))))));
}

export function kerbs(data, state) {
  const root = el('div', { class: 'panel', 'data-view': 'kerbs' });
  if (data.kerbs.length === 0) {
    root.append(el('p', { class: 'muted' }, 'No kerb was found.'));
    return root;
  }
  root.append(table(['place', 'side', { number: 'length' }, { number: 'height' }, { number: 'width' }, { number: 'v' }],
    data.kerbs.map((kerb) => [placeButton(state, kerb.u_begin_m, kerb.u_end_m), kerb.side,
      { number: `${metres(kerb.u_end_m - kerb.u_begin_m)} m` }, { number: mm(kerb.height_m) }, { number: `${fixed(kerb.width_m, 2)} m` },
      { number: `${fixed(kerb.v_begin_m, 1)} … ${fixed(kerb.v_end_m, 1)} m` }])));
  const cards = el('div', { class: 'cards no-print' });
  const add = (begin, end) => cards.append(...data.kerbs.slice(begin, end).map((kerb, k) => el('div', { class: 'card' },
    el('div', { class: 'head' }, el('span', {}, kerb.profile.title), placeButton(state, kerb.u_begin_m, kerb.u_end_m)), makeCrossPlot(kerb.profile, `kerb-${begin + k + 1}`))));
  root.append(el('h3', { class: 'no-print' }, 'Profiles'), cards);
  add(0, 9);
  if (data.kerbs.length > 9) {
    const more = el('button', { type: 'button', onclick: () => { more.remove(); add(9); } }, `Show the other ${data.kerbs.length - 9} profiles`);
    root.append(more);
  }
  return root;
}

function psdChart(tracks) {
  // Bands of a 12th of an octave: the raw lines hide the slope.
  const n0 = 0.1, per = 12;
  const bands = new Map();
  tracks.forEach((track, t) => track.psd.n_cpm.forEach((n, k) => {
    const band = Math.round(per * Math.log2(n / n0));
    if (!bands.has(band)) bands.set(band, tracks.map(() => [0, 0]));
    const cell = bands.get(band)[t];
    cell[0] += track.psd.psd_m3[k];
    cell[1] += 1;
  }));
  const order = [...bands.keys()].filter((band) => n0 * 2 ** (band / per) >= 0.01).sort((a, b) => a - b);
  const n = order.map((band) => n0 * 2 ** (band / per));
  const curves = tracks.map((_, t) => order.map((band) => {
    const [sum, count] = bands.get(band)[t];
    return count > 0 && sum > 0 ? sum / count : null;
  }));
  const letters = ['A', 'B', 'C', 'D', 'E', 'F', 'G', 'H'];
  const limits = letters.slice(0, 7).map((_, k) => n.map((f) => 32e-6 * 4 ** k * (f / n0) ** -2));
  const colours = ['--s1', '--s2', '--s3', '--s4'];
  // What lies more than four decades under class A is the end of the spectrum, not roughness.
  const known = curves.flatMap((curve) => curve.filter((value, k) => value !== null && value > 32e-10 * (n[k] / n0) ** -2));
  const low = Math.min(1e-7, known.reduce((a, b) => Math.min(a, b), 1)), high = known.reduce((a, b) => Math.max(a, b), 1e-5);
  const axes = plainAxes('n / (cycle/m)', 'Gd / m³');
  axes[0].values = (plot, splits) => splits.map((value) => (value && /^[125]/.test(value.toExponential()) ? show(value, 3) : null));
  axes[1].values = (plot, splits) => splits.map((value) => (value && Number.isInteger(Math.round(1e6 * Math.log10(value)) / 1e6) ? `1e${Math.round(Math.log10(value))}` : null));
  return makeChart({
    axes,
    scales: {
      x: { time: false, distr: 3 },
      y: { distr: 3, range: () => [10 ** Math.floor(Math.log10(low)), 10 ** Math.ceil(Math.log10(high))] },
    },
    legend: { live: false },
    cursor: { drag: { x: true, y: false } },
    series: [{ label: 'n / (cycle/m)' },
      ...tracks.map((track, k) => line(track.name, colours[k % 4], { width: 1.8 })),
      ...limits.map((_, k) => ({ label: `${letters[k]}|${letters[k + 1]}`, stroke: () => css('--line'), width: 1, dash: [6, 4], points: { show: false } }))],
    hooks: {
      init: [(plot) => plot.root.querySelectorAll('.u-series').forEach((row, k) => { if (k >= tracks.length) row.style.display = 'none'; })],
      draw: [(plot) => {
        const context = plot.ctx, ratio = window.devicePixelRatio || 1;
        context.save();
        context.beginPath();
        context.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
        context.clip();
        context.font = `${11 * ratio}px system-ui, "DejaVu Sans", sans-serif`;
        context.fillStyle = css('--muted');
        context.textAlign = 'left';
        const at = n[Math.floor(0.06 * n.length)];
        letters.forEach((letter, k) => {
          const y = plot.valToPos(16e-6 * 4 ** k * (at / n0) ** -2, 'y', true);
          context.fillText(letter, plot.valToPos(at, 'x', true), y + 4 * ratio);
        });
        for (const track of tracks) {
          if (!track.facets || track.before) continue;
          const x0 = plot.valToPos(1 / track.facets.p90_m, 'x', true), x1 = plot.valToPos(1 / track.facets.p10_m, 'x', true);
          context.fillStyle = css('--mark');
          context.fillRect(x0, plot.bbox.top, Math.max(2 * ratio, x1 - x0), plot.bbox.height);
          context.fillStyle = css('--fg');
          context.fillText('mesh facets', x0 + 4 * ratio, plot.bbox.top + 14 * ratio);
          break;
        }
        context.restore();
      }],
    },
  }, [n, ...curves, ...limits], 360, {
    view: 'psd', title: 'Displacement spectrum', names: () => tracks.map((track, k) => ({ label: track.name, stroke: () => css(colours[k % 4]) })),
    heads: ['n / (cycle/m)', ...tracks.map((track) => `${track.name}: Gd / m³`), ...limits.map((_, k) => `limit ${letters[k]}|${letters[k + 1]} / m³`)],
  }).box;
}

export function roughness(data, state) {
  const root = el('div', { class: 'panel', 'data-view': 'roughness' });
  const tracks = data.roughness.filter((track) => track.psd.n_cpm.length > 0);
  root.append(table(['path', { number: 'v' }, 'ISO 8608 class', { number: 'Gd(0.1)' }, { number: 'exponent' }, 'fitted band', 'mesh facets'],
    data.roughness.map((track) => {
      const fit = track.iso8608;
      return [track.name, { number: `${fixed(track.v_m, 2)} m` }, fit ? fit.class : track.facets ? `not measurable: facets of ${metres(track.facets.median_m)} m` : 'not measurable', { number: fit ? `${show(1e6 * fit.psd_at_n0_m3, 3)}·10⁻⁶ m³` : '–' },
        { number: fit ? fixed(fit.exponent, 2) : '–' },
        fit ? `${show(fit.n_min_cpm, 2)} to ${show(fit.n_max_cpm, 2)} cycle/m${fit.band_cut ? ', the spectrum ends there' : ''}` : '–',
        track.facets ? `every ${metres(track.facets.median_m)} m (${metres(track.facets.p10_m)} to ${metres(track.facets.p90_m)} m)` : 'none seen'];
    })));
  if (tracks.some((track) => track.facets)) {
    root.append(el('p', { class: 'muted' }, 'The flat facets of the mesh leave kinks at these distances. What the spectrum shows there and above is triangulation, not roughness of the road.'));
  }
  if (tracks.length > 0) root.append(el('h3', {}, 'Displacement spectrum of the wheel paths and the classes of ISO 8608'), psdChart(tracks));
  else root.append(el('p', { class: 'muted' }, 'The road has no piece of 50 m without gaps: no spectrum.'));
  const withIri = data.roughness.filter((track) => track.iri.length > 0);
  if (withIri.length > 0) {
    const colours = ['--s1', '--s2', '--s3', '--s4'];
    // Steps: each value holds over its piece of road.
    const first = withIri[0].iri;
    const u = first.flatMap((piece) => [piece.u_begin_m, piece.u_end_m - 0.01]);
    const rows = withIri.map((track) => track.iri.flatMap((piece) => [piece.iri_m_per_km, piece.iri_m_per_km]).slice(0, u.length));
    root.append(el('h3', {}, 'International Roughness Index per 100 m / (m/km)'), makeLinkedChart(state, {
      axes: plainAxes('u / m', ''),
      series: [line('u / m', '--muted'), ...withIri.map((track, k) => line(track.name, colours[k % 4], { width: 1.8 }))],
      scales: { y: { range: (plot, low, high) => [0, Math.max(0.5, 1.1 * (high ?? 1))] } },
    }, [u, ...rows], 170, {
      view: 'iri', title: 'International Roughness Index / (m/km)', heads: ['u / m', ...withIri.map((track) => `${track.name}: IRI / (m/km)`)],
    }));
  }
  return root;
}

export function health(data) {
  const facts = (list) => table(null, list.map((fact) => [fact.name, fact.value]));
  const root = el('div', { class: 'panel', 'data-view': 'health' },
    el('h3', {}, 'File'), facts(data.file),
    el('h3', {}, 'Inputs'), table(['role', 'path', 'SHA-256'], data.inputs.map((input) => [input.role, input.path, el('code', {}, input.sha256)])));
  if (data.control_points.length > 0) {
    root.append(el('h3', {}, 'Control points'), table(['name', { number: 'x' }, { number: 'y' }, { number: 'residual' }, ''],
      data.control_points.map((point) => [point.name, { number: fixed(point.x_m, 3) }, { number: fixed(point.y_m, 3) }, { number: mm(point.residual_m) }, point.left_out ? 'an outlier, left out' : ''])));
  }
  root.append(el('h3', {}, 'Notes'), data.notes.length > 0
    ? el('ul', {}, data.notes.map((note) => el('li', {}, note))) : el('p', { class: 'muted' }, 'None.'));
  root.append(el('details', {}, el('summary', {}, 'Header'), facts(data.header)));
  if (data.comment.length > 0) root.append(el('details', {}, el('summary', {}, 'Comment'), el('pre', { class: 'mono' }, data.comment.join('\n'))));
  root.append(el('h3', {}, 'Made with'), facts(data.versions));
  if (data.command_line) root.append(el('h3', {}, 'Command'), el('pre', { class: 'mono' }, data.command_line));
  return root;
}

export function extraSections(data) {
  return data.extra.map((section, k) => el('section', { 'data-view': 'extra' }, el('h2', {}, section.title), el('div', { class: 'panel' },
    section.sentences.map((sentence) => el('p', {}, sentence)),
    section.facts.length > 0 ? table(null, section.facts.map((fact) => [fact.name, fact.value])) : null,
    el('div', { class: 'cards' }, section.plots.map((plot, p) => el('div', { class: 'card' }, el('div', { class: 'head' }, plot.title), makeCrossPlot(plot, `extra-${k + 1}-${p + 1}`)))))));
}
