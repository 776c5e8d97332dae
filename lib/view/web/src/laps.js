// Recordings and drives over one another: any channels over time, distance or a road's u, where they differ most, and a map.
import { el, refill } from '../../../report/web/src/dom.js';
import { limitsOf, scaleOf } from '../../../report/web/src/colour.js';
import { show } from '../../../report/web/src/format.js';
import { line, makeChart, plainAxes, refreshCharts } from '../../../report/web/src/charts.js';
import { expressionOf } from './expression.js';
import { lapTable, wholeLaps } from './lap_times.js';
import { getJson, getPacked } from './server.js';

const kMost = 4;  // recordings at once: as many colours tell apart
const kPoints = 4000;
const colours = ['--s1', '--s2', '--s3', '--s4'];

export const guesses = {
  time: /^(log time|time_s|time|t|timestamp|elapsed.*time|session ?time)( ?[[(].*)?$/i,
  x: /^(car\.x|x_m|x|pos(ition)?[_ ]?x.*|.*[._ ]x|east.*)$/i, y: /^(car\.y|y_m|y|pos(ition)?[_ ]?y.*|.*[._ ]y|north.*)$/i,
  speed: /^(car\.vx|vx_mps|vx|speed.*|.*speed.*|v)$/i,
};

const units = { x: 'm', y: 'm', z: 'm', u: 'm', roll: 'rad', pitch: 'rad', yaw: 'rad', vx: 'mps', vy: 'mps', ax: 'mps2', ay: 'mps2', az: 'mps2', steer: 'rad', engine: 'radps', throttle: '', gear: '' }, wheelUnits = { fz: 'n', brake: 'pa' };

/// Names of a unit's variables as the tables of `crgdrive` have them, so that a person's drive lies over one of the built-in driver: car.vx is vx_mps, wheel.fl.fz is fz_fl_n.
export function canonicalName(name) {
  const [, ofCar] = name.match(/^car\.(\w+)$/) ?? [], [, wheel, ofWheel] = name.match(/^wheel\.(fl|fr|rl|rr)\.(\w+)$/) ?? [];
  if (Object.hasOwn(units, ofCar ?? '')) return units[ofCar] ? `${ofCar}_${units[ofCar]}` : ofCar;
  return Object.hasOwn(wheelUnits, ofWheel ?? '') ? `${ofWheel}_${wheel}_${wheelUnits[ofWheel]}` : name;
}

/// Index of the last value that is not above x; values ascend.
function below(values, x) {
  let low = 0, high = values.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (values[middle] <= x) low = middle;
    else high = middle - 1;
  }
  return low;
}

/// On a straight line between neighbours; null beyond the ends. at ascends.
export function sampled(at, values, x) {
  if (at.length === 0 || x < at[0] || x > at[at.length - 1]) return null;
  const k = below(at, x);
  if (k + 1 >= at.length || at[k] === x) return values[k];
  return values[k] + ((x - at[k]) / (at[k + 1] - at[k])) * (values[k + 1] - values[k]);
}

/// Rows of each pass over the road: [first, last] of u going round. u of an open road is one lap.
export function lapsOf(u, length, closed) {
  const laps = [];
  let first = -1, last = -1;
  for (let k = 0; k < u.length; ++k) {
    if (Number.isNaN(u[k])) continue;
    if (first >= 0 && closed && u[k] < u[last] - 0.5 * length) {
      laps.push([first, last]);
      first = k;
    } else if (first < 0) first = k;
    last = k;
  }
  if (first >= 0) laps.push([first, last]);
  return laps.filter(([begin, end]) => end > begin);
}

/// [at, values] of rows first to last where both are numbers and `at` grows.
export function ascending(at, values, first, last) {
  const xs = [], ys = [];
  for (let k = first; k <= last; ++k) {
    if (Number.isNaN(at[k]) || Number.isNaN(values[k]) || (xs.length > 0 && at[k] <= xs[xs.length - 1])) continue;
    xs.push(at[k]);
    ys.push(values[k]);
  }
  return [xs, ys];
}

/// `keep(ids, state)` puts what is chosen into the address: ids of the recordings, each as encodeURIComponent has it, joined by commas.
export function makeLaps({ entriesOf, keep }) {
  const order = [];  // ids in the order in which they were chosen: the first colour is that of the first
  const logs = [];  // those of them that are here: {id, info, names: {time, x, y}, data, laps, lap}
  const note = el('p', { class: 'small', role: 'status', 'data-role': 'note' });
  const chosen = el('div', { class: 'tools' });
  const channel = el('select', { 'aria-label': 'Channel', 'data-role': 'channel' });
  const formula = el('input', { type: 'search', placeholder: 'or reckoned: 3.6 * vx_mps', size: 26, 'aria-label': 'Arithmetic with channels, in place of the channel', 'data-role': 'formula', spellcheck: 'false' });
  const over = el('select', { 'aria-label': 'Over', 'data-role': 'over' }, [['time', 'time'], ['distance', 'distance driven'], ['u', 'u of the road']].map(([key, text]) => el('option', { value: key }, text)));
  const road = el('select', { 'aria-label': 'Road', 'data-role': 'road' });
  const largest = el('p', { 'data-role': 'largest' });
  const charts = el('div'), times = el('div', { 'data-role': 'lap-times' });
  const map = el('canvas', { role: 'img', 'aria-label': 'Map coloured by the channel' });
  const mapLegend = el('p', { class: 'muted small' });
  const root = el('div', { class: 'work', 'data-part': 'laps' },
    el('p', { class: 'muted' }, `Choose up to ${kMost} recordings or drives on the left.`), chosen,
    el('div', { class: 'tools' }, el('label', {}, 'Channel', channel), formula, el('label', {}, 'Over', over), el('label', {}, 'Road', road)),
    note, largest, times, el('div', { class: 'panel' }, charts), el('div', { class: 'panel' }, el('div', { class: 'canvas map' }, map), mapLegend));

  const say = (text) => { note.textContent = text; note.className = `small ${text ? 'bad' : 'muted'}`; };
  const guess = (log, kind) => log.info.channels.find((each) => guesses[kind].test(each.name))?.name ?? null;
  const titleOf = () => formula.value.trim() || channel.value;
  const unitOf = (log, name) => log.info.channels.find((each) => each.name === name)?.unit ?? '';

  function takeAway(id) {
    for (const [list, at] of [[order, order.indexOf(id)], [logs, logs.findIndex((log) => log.id === id)]]) if (at >= 0) list.splice(at, 1);
  }

  /// Why it cannot be read; '': it is there.
  async function choose(id) {
    if (order.length === kMost) takeAway(order[0]);
    order.push(id);
    let info;
    try {
      info = await getJson('log', { id });
      const inFile = new Set(info.channels.map((each) => each.name));
      for (const each of info.channels) Object.assign(each, { file: each.name, name: inFile.has(canonicalName(each.name)) ? each.name : canonicalName(each.name) });
    } catch (error) {
      takeAway(id);
      return error.message;
    }
    if (!order.includes(id) || logs.some((log) => log.id === id)) return '';
    const log = { id, info, names: {}, lap: 0 };
    for (const kind of ['time', 'x', 'y']) log.names[kind] = guess(log, kind);
    logs.push(log);
    logs.sort((a, b) => order.indexOf(a.id) - order.indexOf(b.id));
    return '';
  }

  async function toggle(id) {
    if (order.includes(id)) takeAway(id);
    else {
      const wrong = await choose(id);
      if (wrong) { say(wrong); return; }
    }
    fill();
    await draw();
    remember();
  }

  const boxes = () => [channel, over, road, formula];
  const remember = () => keep(order.map(encodeURIComponent).join(','), [...boxes().map((box) => box.value), ...logs.map((log) => log.lap)].map(encodeURIComponent).join(','));

  /// As the address has it: recordings, then channel, axis, road, arithmetic and the lap of each.
  async function open(ids, state = '') {
    const wanted = ids.split(',').filter(Boolean).map(decodeURIComponent), [, , , , ...lapsOfThem] = state.split(',');
    for (const id of order.filter((each) => !wanted.includes(each))) takeAway(id);
    let wrong = '';
    for (const id of wanted) if (!order.includes(id)) wrong ||= await choose(id);
    fill();
    const values = state.split(',').map(decodeURIComponent);
    for (const [k, box] of boxes().entries()) if (values[k] !== undefined && (box === formula || [...box.options].some((option) => option.value === values[k]))) box.value = values[k];
    for (const log of logs) log.lap = Math.max(0, Math.floor(Number(lapsOfThem[order.indexOf(log.id)]) || 0));
    await draw();
    if (wrong) say(wrong);
    remember();
  }

  function fill() {
    const names = logs.length === 0 ? [] : logs[0].info.channels.map((each) => each.name).filter((name) => logs.every((log) => log.info.channels.some((each) => each.name === name)));
    const kept = channel.value;
    channel.replaceChildren(...names.map((name) => el('option', { value: name }, name)));
    const speed = names.find((name) => guesses.speed.test(name));
    channel.value = names.includes(kept) ? kept : speed ?? names[0] ?? '';
    const roads = entriesOf().filter((entry) => entry.kind === 'road');
    const keptRoad = road.value;
    road.replaceChildren(el('option', { value: '' }, 'none'), ...roads.map((entry) => el('option', { value: entry.id }, entry.id.replace(/^\d+\//, ''))));
    road.value = roads.some((entry) => entry.id === keptRoad) ? keptRoad : '';
    if (logs.length > 1 && names.length === 0) say('These recordings have no channel of the same name; crgexplain map renames channels.');
    else say('');
    refill(chosen, ...logs.map((log, k) => {
      const select = (kind) => {
        const box = el('select', { 'aria-label': `${kind} of ${log.id}` }, el('option', { value: '' }, '–'), log.info.channels.map((each) => el('option', { value: each.name }, each.name)));
        box.value = log.names[kind] ?? '';
        box.addEventListener('change', () => { log.names[kind] = box.value || null; draw(); });
        return el('label', {}, kind, box);
      };
      const lap = el('select', { 'aria-label': `Lap of ${log.id}` });
      log.lapBox = lap;
      lap.addEventListener('change', () => { log.lap = Number(lap.value); draw(); remember(); });
      return el('span', { class: 'pair' }, el('span', { class: 'swatch', style: `background:var(${colours[k]})` }), el('strong', {}, log.id.split('/').at(-1)), select('time'), select('x'), select('y'), el('label', {}, 'lap', lap),
        el('button', { type: 'button', 'aria-label': `Take away ${log.id}`, onclick: () => toggle(log.id) }, '×'));
    }));
  }

  /// Values, place on the axis, and moments of one recording.
  async function read(log) {
    const reckoned = formula.value.trim() ? expressionOf(formula.value) : null;
    const missing = reckoned?.channels.find((name) => !log.info.channels.some((each) => each.name === name));
    if (missing !== undefined) throw new Error(`${log.id}: has no channel '${missing}'`);
    const wanted = [...new Set([...(reckoned?.channels ?? []), channel.value, log.names.time, log.names.x, log.names.y].filter(Boolean))];
    const fileName = (name) => log.info.channels.find((each) => each.name === name).file, sent = await getPacked('channels', { id: log.id, name: wanted.map(fileName) });
    const packed = Object.fromEntries(wanted.map((name) => [name, sent[fileName(name)]]));
    const rows = packed[channel.value].length, time = log.names.time ? packed[log.names.time] : Float64Array.from({ length: rows }, (_, k) => k);
    const values = reckoned ? reckoned.of(packed, time) : packed[channel.value];
    const x = packed[log.names.x], y = packed[log.names.y];
    let at = time, laps = [[0, rows - 1]], closed = false, whole = null;
    if (over.value === 'distance') {
      if (!x || !y) throw new Error(`${log.id}: name its channels for x and y to have a distance`);
      at = new Float64Array(rows);
      let last = -1;
      for (let k = 0; k < rows; ++k) {
        if (Number.isNaN(x[k]) || Number.isNaN(y[k])) { at[k] = NaN; continue; }
        at[k] = last < 0 ? 0 : at[last] + Math.hypot(x[k] - x[last], y[k] - y[last]);
        last = k;
      }
    } else if (over.value === 'u') {
      if (!x || !y) throw new Error(`${log.id}: name its channels for x and y to lay it on the road`);
      if (!road.value) throw new Error('choose the road whose u is meant');
      const places = await getPacked('places', { id: log.id, road: road.value, x: fileName(log.names.x), y: fileName(log.names.y) });
      at = places.u_m;
      ({ closed } = places.head);
      laps = lapsOf(at, places.head.length_m, closed);
      if (log.names.time) whole = wholeLaps(at, time, places.head.length_m, closed);
      if (laps.length === 0) throw new Error(`${log.id}: lies nowhere on this road; is it in the road's frame?`);
    } else {
      const begin = time.find((moment) => !Number.isNaN(moment)) ?? 0;
      at = Float64Array.from(time, (moment) => moment - begin);
    }
    log.lap = Math.min(log.lap, laps.length - 1);
    log.lapBox.replaceChildren(...laps.map((lap, k) => el('option', { value: k }, `${k + 1} (${show(time[lap[1]] - time[lap[0]], 5)} s)`)));
    log.lapBox.value = String(log.lap);
    const [first, last] = laps[log.lap];
    return { line: ascending(at, values, first, last), moments: ascending(at, time, first, last), x, y, values, first, last, whole };
  }

  let drawing = 0;
  async function draw() {
    const turn = ++drawing;
    charts.replaceChildren();
    times.replaceChildren();
    largest.textContent = '';
    delete largest.dataset.at;
    if (logs.length === 0 || !channel.value) { drawMap([]); return; }
    let read_ = [];
    try {
      for (const log of logs) read_.push(await read(log));
      say('');
    } catch (error) {
      if (turn === drawing) say(error.message);
      return;
    }
    if (turn !== drawing) return;
    const shown = read_.filter(({ line: [at] }) => at.length > 1);
    if (shown.length === 0) { say('No numbers in this channel.'); return; }
    const low = Math.min(...shown.map(({ line: [at] }) => at[0])), high = Math.max(...shown.map(({ line: [at] }) => at[at.length - 1]));
    const grid = Array.from({ length: kPoints }, (_, k) => low + ((high - low) * k) / (kPoints - 1));
    const curves = read_.map(({ line: [at, values] }) => grid.map((place) => sampled(at, values, place)));
    const title = titleOf(), unit = over.value === 'time' ? 't / s' : over.value === 'u' ? 'u / m' : 's / m', channelUnit = formula.value.trim() ? '' : unitOf(logs[0], channel.value);
    const names = logs.map((log) => log.id.split('/').at(-1));
    const timed = read_.map(({ whole }, k) => ({ name: names[k], colour: colours[k], laps: whole })).filter(({ laps }) => laps !== null);
    if (timed.length > 0) times.append(lapTable(timed));
    const sync = { key: 'laps' };
    const chart = (title, yLabel, columns, labels, shades, view) => makeChart({
      axes: plainAxes(unit, yLabel), scales: { x: { time: false } }, cursor: { sync, drag: { x: true, y: false } },
      series: [{ label: unit }, ...labels.map((label, k) => line(label, shades[k]))],
    }, [grid, ...columns], view === 'values' ? 260 : 150, { view, title }).box;
    charts.append(chart(title, `${title}${channelUnit ? ` / ${channelUnit}` : ''}`, curves, names, colours, 'values'));
    if (read_.length > 1) {
      const differences = curves.slice(1).map((curve) => curve.map((value, k) => (value === null || curves[0][k] === null ? null : value - curves[0][k])));
      charts.append(chart('Difference to the first', `Δ${channelUnit ? ` / ${channelUnit}` : ''}`, differences, names.slice(1), colours.slice(1), 'difference'));
      let best = -1, size = 0, who = 0;
      differences.forEach((row, n) => row.forEach((value, k) => { if (value !== null && Math.abs(value) > size) { size = Math.abs(value); best = k; who = n; } }));
      if (best >= 0) {
        largest.textContent = `Largest difference of ${title}: ${show(differences[who][best], 4)}${channelUnit ? ` ${channelUnit}` : ''} (${names[who + 1]} less ${names[0]}) at ${unit.split(' ')[0]} = ${show(grid[best], 5)} ${unit.split(' ')[2]}.`;
        largest.dataset.at = grid[best];
      }
      if (over.value !== 'time') {
        const since = ({ moments: [at, time] }) => grid.map((place) => { const now = sampled(at, time, place); return now === null ? null : now - time[0]; });
        const first = since(read_[0]);
        charts.append(chart('Time lost against the first', 'Δt / s', read_.slice(1).map((each) => since(each).map((t, k) => (t === null || first[k] === null ? null : t - first[k]))), names.slice(1), colours.slice(1), 'delta-time'));
      }
    }
    drawMap(read_);
    root.dataset.drawn = String(turn);
  }

  function drawMap(all) {
    const ratio = Math.min(2, window.devicePixelRatio || 1), width = map.clientWidth, height = map.clientHeight;
    map.width = Math.max(1, Math.floor(width * ratio));
    map.height = Math.max(1, Math.floor(height * ratio));
    const context = map.getContext('2d');
    mapLegend.textContent = '';
    const placed = all.filter(({ x, y }) => x && y);
    let [lowX, highX, lowY, highY] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const { x, y, first, last } of placed) {
      for (let k = first; k <= last; ++k) {
        if (Number.isNaN(x[k]) || Number.isNaN(y[k])) continue;
        [lowX, highX, lowY, highY] = [Math.min(lowX, x[k]), Math.max(highX, x[k]), Math.min(lowY, y[k]), Math.max(highY, y[k])];
      }
    }
    if (!(highX > lowX || highY > lowY)) { mapLegend.textContent = all.length > 0 ? 'No map: name the channels for x and y.' : ''; return; }
    const scale = 0.94 * Math.min(map.width / Math.max(1e-9, highX - lowX), map.height / Math.max(1e-9, highY - lowY));
    const every = placed.flatMap(({ values, first, last }) => Array.from(values.slice(first, last + 1)));
    const [low, high] = limitsOf(every, false);
    const colour = scaleOf({ categories: [], signed: false, values: every }, every);
    placed.forEach(({ x, y, values, first, last }, n) => {
      const step = Math.max(1, Math.floor((last - first) / 8000)), size = (placed.length > 1 && n === 0 ? 5 : 3) * ratio;
      for (let k = first; k <= last; k += step) {
        const rgb = colour.of(values[k]);
        if (!rgb || Number.isNaN(x[k])) continue;
        context.fillStyle = `rgb(${rgb.map(Math.round).join(',')})`;
        context.fillRect(map.width / 2 + scale * (x[k] - 0.5 * (lowX + highX)) - size / 2, map.height / 2 - scale * (y[k] - 0.5 * (lowY + highY)) - size / 2, size, size);
      }
    });
    mapLegend.textContent = `${titleOf()}: ${show(low, 4)} (dark) to ${show(high, 4)} (bright); ${show(highX - lowX, 4)} m by ${show(highY - lowY, 4)} m`;
  }

  for (const box of [channel, over, road, formula]) box.addEventListener('change', () => { draw(); remember(); });
  return { root, toggle, open, chosen: () => logs.map((log) => log.id), refresh: () => { fill(); refreshCharts(); } };
}
