// Clouds: made into tiles, flown through, coloured by what the points carry.
import { el, refill } from '../../../report/web/src/dom.js';
import { count, mm, show } from '../../../report/web/src/format.js';
import { makeCloudStage } from './cloud_stage.js';
import { endOf, run } from './jobs.js';
import { pictureButton } from '../../../report/web/src/save.js';
import { classNames, ofClass, ofNumber, ofShare, ofSigned } from './point_colours.js';
import { getBytes, getJson, getPacked } from './server.js';
import { bytesOf, indexOf, placesOf } from './tiles.js';

const names = { height: 'Height', intensity: 'Intensity', sigma_m: 'Standard deviation', class: 'Class', pass: 'Pass', difference: 'Difference to the road' };
const kOfRoad_m = 1;  // a point further above or below belongs to something else
const budgets = [100000, 300000, 1000000, 3000000, 10000000];
const folderOf = (id) => id.replace(/[^/]*$/, '');
/// A file, or what lies between two gaps of a trajectory.
const passName = ({ path, time_s: time }) => `${path}${Array.isArray(time) ? `, ${show(time[0], 9, 1)} to ${show(time[1], 9, 1)} s` : ''}`;
const shortOf = (id) => id.replace(/^\d+\//, '');

/// `changed()` reads the list of files again and resolves to it; `openTiles(id)` shows an index; `keep(id, state)` puts what is seen into the address.
export function makeScans({ changed, entriesOf, openTiles, keep }) {
  let id = null, index = null, cloud = null, colour = 'height', spread = [0, 1], road = null, waited = 0;
  const note = el('p', { class: 'small', role: 'status', 'data-role': 'note' });
  const say = (text, kind = 'muted') => { note.className = `small ${kind}`; note.textContent = text; };
  const shown = el('p', { class: 'small', 'data-role': 'shown' }), point = el('p', { class: 'small', 'data-role': 'point' }), facts = el('div', { class: 'small', 'data-role': 'facts' });
  const legend = el('div', { class: 'small', 'data-role': 'legend' });
  const swatch = (rgb) => el('span', { class: 'swatch', style: `background:rgb(${rgb.map(Math.round).join(',')})` });

  const colourOf = {
    height: (data, k, rgb) => ofShare((data.xyz_m[3 * k + 2] + data.origin[2] - spread[0]) / (spread[1] - spread[0]), rgb),
    intensity: (data, k, rgb) => ofShare((data.intensity[k] - spread[0]) / (spread[1] - spread[0]), rgb),
    sigma_m: (data, k, rgb) => ofShare((data.sigma_m[k] - spread[0]) / (spread[1] - spread[0]), rgb),
    class: (data, k, rgb) => ofClass(data.class[k], rgb),
    pass: (data, k, rgb) => ofNumber(data.pass[k], rgb),
    difference: (data, k, rgb) => ofSigned(data.difference && Math.abs(data.difference[k]) <= kOfRoad_m ? data.difference[k] / spread[1] : NaN, rgb),
  };
  const stage = makeCloudStage({
    fetchTile: (tile) => getBytes('part', { id: folderOf(id) + index.file, begin: tile.begin, bytes: bytesOf(index, tile) }),
    // Differences are those of the road's own surface, reckoned where it is read.
    addTo: async (data, tile) => {
      if (road) data.difference = new Float32Array(await getBytes('heights', { id: folderOf(id) + index.file, road: road.id, begin: placesOf(index, tile), points: tile.points, x: tile.origin[0], y: tile.origin[1], z: tile.origin[2] }));
    },
    colourOf: (data, k, rgb) => colourOf[colour](data, k, rgb),
    told({ drawn, waiting }) {
      shown.textContent = index ? `${count(drawn)} of ${count(index.points)} points drawn${waiting > 0 ? `; ${count(waiting)} tiles to come` : ''}` : '';
      if (waiting === 0 && waited > 0) tellDifferences();
      waited = waiting;
    },
    picked(at) {
      if (!at) { point.textContent = 'No point there.'; return; }
      const more = [['intensity', (value) => show(value, 4)], ['sigma_m', mm, 'standard deviation'], ['class', (value) => `${value}${classNames[value] ? ` (${classNames[value]})` : ''}`], ['pass', (value) => (index.passes?.[value] ? passName(index.passes[value]) : value)],
        ['difference', (value) => (Number.isNaN(value) ? 'none: beside the road' : `to the road ${mm(value)}`)]];
      point.textContent = `x ${at.x_m.toFixed(3)} m, y ${at.y_m.toFixed(3)} m, z ${at.z_m.toFixed(3)} m${more.filter(([name]) => at.data[name]).map(([name, text, label = name]) => ` · ${label} ${text(at.data[name][at.k])}`).join('')}`;
    },
    moved() { remember(); tellDifferences(); },
    failed: (error) => say(error.message, 'bad'),
  });

  const colourBox = el('select', { 'aria-label': 'Colour of the points', 'data-role': 'colour' });
  const budgetBox = el('select', { 'aria-label': 'Points drawn at most', 'data-role': 'budget' }, budgets.map((value) => el('option', { value }, count(value))));
  const finestBox = el('input', { type: 'number', min: 0, max: 50, step: 0.5, value: stage.limits.finest_px ?? 1.5, 'aria-label': 'Finest distance of points in the picture, px', 'data-role': 'finest' });
  const roadBox = el('select', { 'aria-label': 'Road below the points', 'data-role': 'road' });
  const limitBox = el('input', { type: 'number', min: 0.1, max: 1000 * kOfRoad_m, step: 'any', value: 50, 'aria-label': 'Difference of the darkest colours, mm', 'data-role': 'limit' });
  const limitLabel = el('label', { hidden: '' }, '± mm', limitBox), differences = el('p', { class: 'small', 'data-role': 'differences' });
  const button = (role, text, action) => el('button', { type: 'button', 'data-role': role, onclick: action }, text);
  const poses = el('select', { 'aria-label': 'Trajectory, for points in the frame of the sensor', 'data-role': 'trajectory' });
  const whole = el('input', { type: 'checkbox', 'data-role': 'whole' }), wholeText = document.createTextNode('');
  const maker = el('div', { hidden: '' }, el('p', { class: 'small' }, 'A cloud is drawn from tiles, which are made once. The command:'),
    el('pre', { class: 'small', 'data-role': 'command' }), el('div', { class: 'tools' }, el('label', {}, 'Trajectory', poses), el('label', {}, whole, wholeText), button('make-tiles', el('strong', {}, 'Make tiles'), make)));
  const root = el('div', { class: 'work', 'data-part': 'scans' }, el('div', { class: 'split' },
    el('div', {}, el('div', { class: 'tools' }, el('label', {}, 'Colour', colourBox), el('label', {}, 'Points at most', budgetBox), el('label', {}, 'Finest / px', finestBox),
      el('label', {}, 'Road', roadBox), limitLabel, button('fit', 'All', () => stage.fit()), button('above', 'From above', () => stage.above()),
      pictureButton('scan', () => ({ canvas: stage.picture(), title: index ? shortOf(id) : '' }))), stage.box),
    el('div', { class: 'side' }, note, maker, shown, point, legend, differences, el('h2', {}, 'Cloud'), facts)));
  budgetBox.value = String(stage.isSlow ? 300000 : 1000000);
  stage.limits.most = Number(budgetBox.value);

  /// colour, where the camera is and what it looks at, the road.
  function remember() {
    const at = stage.state();
    if (index && at) keep(id, [colour, ...at, ...(road ? [encodeURIComponent(road.id)] : [])].join(','));
  }

  /// Of the points that are drawn and belong to the road: the middle one, and within what of it nine in ten lie.
  function tellDifferences() {
    if (!road) { differences.textContent = ''; return; }
    const all = [];
    for (const { difference } of stage.shown()) for (const d of difference ?? []) if (Math.abs(d) <= kOfRoad_m) all.push(d);
    if (all.length === 0) { differences.textContent = 'No point that is drawn lies on this road.'; return; }
    const at = Float32Array.from(all).sort(), share = (part) => at[Math.round(part * (at.length - 1))];
    differences.textContent = `${count(at.length)} points lie within ${kOfRoad_m} m of the road: the middle one ${mm(share(0.5))} above it, nine in ten from ${mm(share(0.05))} to ${mm(share(0.95))}.`;
    differences.dataset.middle = share(0.5);
  }

  /// Fields of this cloud that can be colours, the wanted one chosen.
  function offerColours(wanted) {
    const has = (name) => index.fields.some((field) => field.name === name);
    const offered = ['height', ...['intensity', 'sigma_m', 'class'].filter(has), ...(has('pass') && index.passes?.length > 1 ? ['pass'] : []), ...(road ? ['difference'] : [])];
    colour = [wanted, colour].find((each) => offered.includes(each)) ?? 'height';
    colourBox.replaceChildren(...offered.map((each) => el('option', { value: each }, names[each])));
    colourBox.value = colour;
  }

  /// Lays a road below the points; '': none.
  async function useRoad(next) {
    const of = id;
    let packed = null;
    try {
      if (next) packed = await getPacked('road', { id: next });
    } catch (error) {
      say(error.message, 'bad');
    }
    if (of !== id) return;
    road = packed ? { id: next } : null;
    roadBox.value = road ? next : '';
    stage.setRoad(packed);
    stage.refresh();
    tellDifferences();
  }
  roadBox.addEventListener('change', async () => {
    await useRoad(roadBox.value);
    if (!index) return;
    offerColours(road ? 'difference' : 'height');
    paint();
    remember();
  });
  limitBox.addEventListener('input', () => { if (limitBox.validity.valid && limitBox.valueAsNumber > 0) paint(); });

  function paint() {
    const limit_m = 1e-3 * limitBox.valueAsNumber, isHeight = colour === 'height';
    const range = isHeight ? [index.most_min_m[2], index.most_max_m[2]] : colour === 'difference' ? [-limit_m, limit_m] : index[colour] ?? [0, 1];
    const told = (value) => (colour === 'difference' || colour === 'sigma_m' ? mm(value) : `${show(value, 5)}${isHeight ? ' m' : ''}`);
    limitLabel.hidden = colour !== 'difference';
    spread = range[1] > range[0] ? range : [range[0] - 0.5, range[0] + 0.5];
    const rgb = [0, 0, 0], rows = colour === 'class' ? Object.entries(index.classes).map(([number, points]) => [Number(number), `${number} ${classNames[number] ?? ''}: ${count(points)}`])
      : colour === 'pass' ? index.passes.map((pass, k) => [k, `${passName(pass)}: ${count(pass.points)}`]) : null;
    refill(legend, ...(rows ? [el('ul', { style: 'list-style:none;padding:0' }, rows.slice(0, 60).map(([k, text]) => { (colour === 'class' ? ofClass : ofNumber)(k, rgb); return el('li', {}, swatch(rgb), text); })), rows.length > 60 ? el('p', {}, `and ${rows.length - 60} more`) : '']
      : [el('p', {}, `${told(spread[0])} `,
        [0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1].map((t) => { if (colour === 'difference') ofSigned(2 * t - 1, rgb); else ofShare(t, rgb); return swatch(rgb); }),
        ` ${told(spread[1])}${colour === 'difference' ? `; red: above the road; grey: beside it, or more than ${kOfRoad_m} m away` : ''}`)]));
    stage.recolour();
  }
  colourBox.addEventListener('change', () => { colour = colourBox.value; paint(); remember(); });
  budgetBox.addEventListener('change', () => { stage.limits.most = Number(budgetBox.value); stage.redraw(); });
  finestBox.addEventListener('input', () => { if (finestBox.valueAsNumber >= 0) { stage.limits.finest_px = finestBox.valueAsNumber; stage.redraw(); } });

  const chosenClouds = () => (whole.checked ? besides() : [cloud]);
  const besides = () => entriesOf().filter((entry) => entry.kind === 'scan' && folderOf(entry.id) === folderOf(cloud)).map((entry) => entry.id);
  function tellCommand() {
    const clouds = chosenClouds().map(shortOf);
    maker.querySelector('pre').textContent = `lidar2mesh tiles ${clouds.slice(0, 3).join(' ')}${clouds.length > 3 ? ` ... (${clouds.length} clouds)` : ''}${poses.value ? ` --trajectory ${shortOf(poses.value)}` : ''}`;
  }
  poses.addEventListener('change', tellCommand);
  whole.addEventListener('change', tellCommand);

  async function make() {
    const of = cloud;
    say('Making tiles …');
    const job = await run({ do: 'tiles', clouds: chosenClouds(), trajectory: poses.value }).catch((error) => ({ exit_code: 1, messages: error.message }));
    if (of !== cloud) return;
    if (job.exit_code !== 0) { say(job.messages?.trim() || endOf(job), 'bad'); return; }
    say('');
    await changed();
    openTiles(`0/${job.result}/tiles.json`);
  }

  function offer(next) {
    cloud = next;
    const tables = entriesOf().filter((entry) => entry.kind === 'table');
    poses.replaceChildren(el('option', { value: '' }, 'none: the points lie in the map'), ...tables.map((entry) => el('option', { value: entry.id }, shortOf(entry.id))));
    const beside = tables.find((entry) => entry.id === `${folderOf(next)}trajectory.csv`);
    if (beside) poses.value = beside.id;
    wholeText.data = `all ${besides().length} clouds of the folder`;
    whole.checked = besides().length > 1;
    tellCommand();
  }

  async function open(next, state = '') {
    id = next;
    index = cloud = null;
    stage.clear();
    say('');
    for (const node of [shown, point, legend, facts]) node.replaceChildren();
    const isCloud = !next.endsWith('tiles.json');
    maker.hidden = !isCloud;
    if (isCloud) { offer(next); return; }
    let read;
    try {
      read = indexOf(await getJson('file', { id: next }));
    } catch (error) {
      if (id === next) say(error.message, 'bad');
      return;
    }
    if (id !== next) return;
    index = read;
    const [wanted, ...rest] = state.split(','), places = rest.slice(0, 6), wantedRoad = rest[6] ? decodeURIComponent(rest[6]) : road?.id ?? '';
    const roads = entriesOf().filter((entry) => entry.kind === 'road' && !/\.(patch-\d+|friction)\.crg$/.test(entry.id));
    roadBox.replaceChildren(el('option', { value: '' }, 'none'), ...roads.map((entry) => el('option', { value: entry.id }, shortOf(entry.id))));
    await useRoad(roads.some((entry) => entry.id === wantedRoad) ? wantedRoad : '');
    if (id !== next) return;
    offerColours(wanted);
    const size = index.most_min_m.map((low, k) => index.most_max_m[k] - low);
    facts.replaceChildren(el('p', {}, `${count(index.points)} points in ${count(index.tiles.length)} tiles of ${index.levels.length} levels, ${show(size[0], 4, 1)} x ${show(size[1], 4, 1)} m, heights ${show(index.most_min_m[2], 6, 2)} to ${show(index.most_max_m[2], 6, 2)} m.`),
      ...(index.remarks ?? []).map((remark) => el('p', { class: 'warn' }, String(remark))));
    stage.open(index);
    paint();
    if (places.length === 6 && places.map(Number).every(Number.isFinite)) stage.restore(places.map(Number));
  }
  return { root, open, redraw: stage.redraw };
}
