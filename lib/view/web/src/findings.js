// What crgexplain found: what is missing, where on the road, how sure; each finding over the road and over u.
import { css, el, table } from '../../../report/web/src/dom.js';
import { show } from '../../../report/web/src/format.js';
import { line, makeChart, plainAxes } from '../../../report/web/src/charts.js';
import { endOf, run } from './jobs.js';
import { fileAddress, getJson, getPacked } from './server.js';

const verdicts = {
  none: ['usable', 'Nothing is missing', 'The simulation explains the recordings.'],
  explained: ['usable', 'Explained', 'What was missing is named below; it holds on laps that were not used to find it.'],
  tie: ['usable_with_remarks', 'A tie', 'Several explanations fit as well as one another; the recordings cannot tell them apart.'],
  'not judged': ['usable_with_remarks', 'Not judged', 'A column is broken and was left out; what hangs on it was not looked at. Mend it, and run again.'],
  unknown: ['not_usable', 'Something unknown', 'There is a mismatch that none of the known mechanisms explains.'],
};
const list = (value) => (Array.isArray(value) ? value : []);
const amount = (value, unit) => `${show(value, 4)}${unit && unit !== '1' ? ` ${unit}` : ''}`;
const interval = (each) => (Array.isArray(each.ci90) ? ` (90 %: ${show(each.ci90[0], 4)} to ${show(each.ci90[1], 4)})` : '');
const stretches = (where) => (where === null || where === undefined ? 'everywhere' : list(where).map((each) => `u ${show(each.u_begin_m, 6, 0)} to ${show(each.u_end_m, 6, 0)} m`).join(', '));

/// Whether u lies in one of the stretches; one that begins behind its end goes over the start.
export function isWithin(u, where) {
  return list(where).some(({ u_begin_m: begin, u_end_m: end }) => (begin <= end ? u >= begin && u <= end : u >= begin || u <= end));
}

/// `openLaps(ids, state)` shows drives over one another; `keep(id, road)` puts what is shown into the address.
export function makeFindings({ entriesOf, changed, openLaps, keep }) {
  let road = null, chosen = null, id = null;
  const roadBox = el('select', { 'aria-label': 'Road to show', 'data-role': 'road' });
  const body = el('div'), charts = el('div'), note = el('p', { class: 'small', role: 'status', 'data-role': 'note' });
  const map = el('canvas', { role: 'img', 'aria-label': 'The road, with the stretches of what is chosen' });
  const frame = el('iframe', { title: 'Report of crgexplain', sandbox: 'allow-scripts allow-downloads', hidden: '' });
  const reportButton = el('button', { type: 'button', 'data-role': 'report', onclick: () => {
    const report = entriesOf().find((entry) => entry.kind === 'report' && entry.id === id.replace(/[^/]*$/, 'report.html'));
    frame.hidden = !report;
    if (report) frame.src = fileAddress(report);
    else note.textContent = 'No report.html lies beside these findings.';
  } }, 'Show the whole report');
  const carBox = el('select', { 'aria-label': 'The car as it was stated', 'data-role': 'car' });
  const lapsButton = el('button', { type: 'button', 'data-role': 'corrected', title: 'The built-in driver drives a lap with what was stated, and one with what was corrected; both are shown over one another', onclick: driveBoth }, 'Corrected against stated');
  const root = el('div', { class: 'work', 'data-part': 'findings' },
    el('div', { class: 'tools' }, el('label', {}, 'Stated road', roadBox), el('label', {}, 'car', carBox), lapsButton, reportButton), note,
    el('div', { class: 'two even' }, body, el('div', {}, el('div', { class: 'panel' }, el('div', { class: 'canvas map' }, map)), charts)), frame);

  /// What lies beside the findings: the corrected inputs.
  const beside = (name) => entriesOf().find((entry) => entry.id === id.replace(/[^/]*$/, name))?.id;
  const say = (text, kind = 'muted') => { note.className = `small ${kind}`; note.textContent = text; };

  async function driveBoth() {
    const of = id, stated = { vehicle: carBox.value, road: roadBox.value }, corrected = { vehicle: beside('vehicle.yaml') ?? stated.vehicle, road: beside('track.crg') ?? stated.road };
    if (!stated.vehicle || !stated.road) { say('Choose the road and the car as they were stated.', 'warn'); return; }
    if (beside('friction.crg')) corrected.friction = beside('friction.crg');
    if (JSON.stringify(corrected) === JSON.stringify(stated)) { say('Nothing was corrected: no vehicle.yaml, track.crg or friction.crg lies beside these findings.', 'warn'); return; }
    const driven = [];
    for (const [word, wish] of [['stated', stated], ['corrected', corrected]]) {
      say(`A lap with what was ${word} …`);
      const job = await run({ do: 'lap', ...wish }).catch((error) => ({ exit_code: 1, messages: error.message }));
      if (of !== id) return;
      if (job.exit_code !== 0) { say(job.messages?.trim() || endOf(job), 'bad'); return; }
      driven.push(`0/${job.result}`);
    }
    say('');
    await changed();
    openLaps(driven, ['vx_mps', 'u', stated.road, ''].map(encodeURIComponent).join(','));
  }

  function drawMap() {
    const ratio = Math.min(2, window.devicePixelRatio || 1), context = map.getContext('2d');
    map.width = Math.max(1, Math.floor(map.clientWidth * ratio));
    map.height = Math.max(1, Math.floor(map.clientHeight * ratio));
    if (!road) return;
    const range = (values) => [Math.min(...values), Math.max(...values)], [[lowX, highX], [lowY, highY]] = [range(road.x_m), range(road.y_m)];
    const scale = 0.92 * Math.min(map.width / Math.max(1, highX - lowX), map.height / Math.max(1, highY - lowY));
    const at = (k) => [map.width / 2 + scale * (road.x_m[k] - 0.5 * (lowX + highX)), map.height / 2 - scale * (road.y_m[k] - 0.5 * (lowY + highY))];
    context.lineCap = 'round';
    for (let k = 1; k < road.head.rows; ++k) {
      const lit = chosen && chosen.where && isWithin(road.u_m[k] - road.head.u_begin_m, chosen.where);
      context.strokeStyle = css(lit ? '--cursor' : '--none');
      context.lineWidth = (lit ? 5 : 2) * ratio;
      context.beginPath();
      context.moveTo(...at(k - 1));
      context.lineTo(...at(k));
      context.stroke();
    }
  }
  new ResizeObserver(drawMap).observe(map);

  function choose(each) {
    chosen = each;
    for (const button of body.querySelectorAll('[data-finding]')) button.setAttribute('aria-pressed', String(button.finding === each));
    charts.replaceChildren();
    const profile = list(each?.profile);
    if (profile.length > 1) {
      const rows = [profile.map((p) => p.u_m), profile.map((p) => p.value), profile.map((p) => p.value - p.ci90), profile.map((p) => p.value + p.ci90)];
      const unit = list(each.parameters)[0]?.unit ?? '';
      charts.append(el('div', { class: 'panel' }, makeChart({
        axes: plainAxes('u / m', unit), scales: { x: { time: false } }, cursor: { drag: { x: true, y: false } },
        series: [{ label: 'u / m' }, line('value', '--s1'), line('90 % from', '--s2', { width: 1 }), line('to', '--s2', { width: 1 })],
      }, rows, 200, { view: 'profile', title: each.physics ?? 'profile' }).box));
    }
    drawMap();
  }

  const pick = (each, text) => {
    const button = el('button', { type: 'button', class: 'place', 'data-finding': '', 'aria-pressed': 'false', onclick: () => choose(each) }, text);
    button.finding = each;
    return button;
  };

  function fill(found) {
    const [kind, word, sentence] = verdicts[found.verdict] ?? ['', String(found.verdict), ''];
    const findings = list(found.findings).map((each) => el('div', { class: 'card' },
      el('div', { class: 'head' }, el('strong', {}, each.mechanism), pick(each, stretches(each.where))),
      el('p', {}, each.physics), el('p', { class: 'mono' }, each.equation),
      el('ul', {}, list(each.parameters).map((parameter) => el('li', {}, `${parameter.name}: ${amount(parameter.value, parameter.unit)}${interval(parameter)}`))),
      list(each.rivals).length > 0 ? el('p', {}, `As good: ${list(each.rivals).map((rival) => rival.mechanism ?? rival).join(', ')}`) : null,
      list(each.held_out).length > 0 ? table(['on laps not used', 'before', 'after'], list(each.held_out).map((out) => [`${out.channel}`, { number: amount(out.rmse_before, out.unit) }, { number: amount(out.rmse_after, out.unit) }])) : null));
    const rows = (values, what) => values.map((each) => [each.channel, pick(each, stretches(each.where)), { number: amount(each.size, each.unit) }, String(each[what] ?? '')]);
    const part = (title, values, what, head) => (values.length === 0 ? null : [el('h3', {}, title), table(['channel', 'where', 'size', head], rows(values.slice(0, 40), what))]);
    body.replaceChildren(...[
      el('div', { class: `panel verdict ${kind}`, 'data-role': 'verdict' }, el('strong', {}, word), el('span', {}, sentence)),
      findings.length > 0 ? el('div', {}, findings) : null,
      part('Mismatches, before anything was refitted', list(found.mismatches), 'regime', 'regime'),
      part('Not explained', list(found.unexplained), 'locked_to', 'goes with'),
      list(found.untestable).length > 0 ? el('details', {}, el('summary', {}, 'What could not be tested'), el('ul', {}, list(found.untestable).map((each) => el('li', {}, `${each.mechanism}: ${each.reason}`)))) : null,
      list(found.remarks).length > 0 ? el('details', {}, el('summary', {}, 'Remarks'), el('ul', {}, list(found.remarks).map((remark) => el('li', {}, remark)))) : null,
    ].flat().filter(Boolean));
  }

  async function showRoad() {
    road = null;
    try {
      if (roadBox.value) road = await getPacked('road', { id: roadBox.value });
    } catch (error) {
      note.textContent = error.message;
    }
    drawMap();
  }
  roadBox.addEventListener('change', () => { showRoad(); keep(id, roadBox.value); });

  async function open(next, wantedRoad = '') {
    id = next;
    frame.hidden = true;
    note.textContent = '';
    const roads = entriesOf().filter((entry) => entry.kind === 'road'), kept = wantedRoad || roadBox.value;
    roadBox.replaceChildren(el('option', { value: '' }, 'none'), ...roads.map((entry) => el('option', { value: entry.id }, entry.id.replace(/^\d+\//, ''))));
    const isOwn = (entry) => entry.id.replace(/[^/]*$/, '') === id.replace(/[^/]*$/, '');
    roadBox.value = roads.some((entry) => entry.id === kept) ? kept : (roads.find((entry) => !isOwn(entry)) ?? roads[0])?.id ?? '';
    const cars = entriesOf().filter((entry) => entry.kind === 'car' && !isOwn(entry)), keptCar = carBox.value;
    carBox.replaceChildren(el('option', { value: '' }, 'none'), ...cars.map((entry) => el('option', { value: entry.id }, entry.id.replace(/^\d+\//, ''))));
    carBox.value = cars.some((entry) => entry.id === keptCar) ? keptCar : cars[0]?.id ?? '';
    let found;
    try {
      found = await getJson('file', { id });
    } catch (error) {
      note.textContent = error.message;
      body.replaceChildren();
      return;
    }
    fill(found);
    choose(list(found.findings)[0] ?? list(found.mismatches)[0] ?? null);
    await showRoad();
  }
  return { root, open };
}
