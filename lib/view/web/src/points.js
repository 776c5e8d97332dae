// Control points: places of the mesh and where they are on a map, in metres or in degrees.
import { el, refill, table } from '../../../report/web/src/dom.js';
import { valueOf, withPath } from './recipe.js';

const ofMesh = ['mesh_x_m', 'mesh_y_m', 'mesh_z_m'];
const ofMap = { metres: ['x_m', 'y_m', 'z_m'], degrees: ['lat_deg', 'lon_deg', 'h_m'] };
const labels = { metres: ['east / m', 'north / m', 'up / m'], degrees: ['latitude / °', 'longitude / °', 'height / m'] };

/// {unit, points: [[x, y, z, ...map]], names}. Throws where the columns are not there.
export function pointsOf(text) {
  const rows = text.split(/\r?\n/).filter((line) => line.trim() && !line.startsWith('#')).map((line) => line.split(',').map((cell) => cell.trim()));
  const head = rows[0] ?? [], unit = head.includes('lat_deg') ? 'degrees' : 'metres';
  const at = [...ofMesh, ...ofMap[unit]].map((name) => head.indexOf(name));
  if (at.includes(-1)) throw new Error(`The file of control points has no column ${[...ofMesh, ...ofMap[unit]][at.indexOf(-1)]}.`);
  const name = head.indexOf('name');
  return { unit, points: rows.slice(1).map((row) => at.map((k) => Number(row[k]))), names: rows.slice(1).map((row, k) => (name < 0 ? `point ${k + 1}` : row[name])) };
}

export function pointsText({ unit, points, names }) {
  const cells = (name, values) => [name.replace(/[,\r\n"]/g, ' '), ...values.map((value, k) => Number(value.toFixed(unit === 'degrees' && k > 2 && k < 5 ? 9 : 4)))].join(',');
  return `${['name', ...ofMesh, ...ofMap[unit]].join(',')}\n${points.map((values, k) => `${cells(names[k], values)}\n`).join('')}`;
}

export function makePoints({ draft, say }) {
  let known = { unit: 'metres', points: [], names: [] }, place = null;
  const unit = el('select', { 'aria-label': 'What a map gives', 'data-role': 'map-unit' }, Object.keys(ofMap).map((each) => el('option', { value: each }, each)));
  const name = el('input', { 'aria-label': 'Name of the point', placeholder: 'name', 'data-role': 'point-name' });
  const inputs = [0, 1, 2].map((k) => el('input', { type: 'number', step: 'any', required: '', 'data-map': k }));
  const texts = inputs.map(() => document.createTextNode(''));
  const at = el('span', { class: 'small', 'data-role': 'point-place' }), list = el('div', { 'data-role': 'points' });
  const form = el('form', { class: 'tools' }, el('label', {}, 'a map gives', unit), inputs.map((input, k) => el('label', {}, texts[k], input)), name, el('button', { type: 'submit', 'data-role': 'add-point' }, 'Add'));
  const root = el('details', { 'data-role': 'control-points' }, el('summary', {}, 'Control points'), at, form, list);
  const label = () => labels[unit.value].forEach((text, k) => { texts[k].data = text; });
  unit.addEventListener('change', label);

  const showPlace = () => { at.textContent = place ? `Place of the mesh: x ${place[0].toFixed(3)} m, y ${place[1].toFixed(3)} m, z ${place[2].toFixed(3)} m` : 'Choose "Control point", then a place of the mesh that a map shows too.'; };
  function fill() {
    unit.value = known.unit;
    unit.disabled = known.points.length > 0;
    label();
    showPlace();
    refill(list, known.points.length > 0 ? table(['point', 'of the mesh', 'of the map', ''], known.points.map((values, k) => [known.names[k], values.slice(0, 3).map((value) => value.toFixed(1)).join(', '), values.slice(3).join(', '),
      el('button', { type: 'button', 'aria-label': `Take away ${known.names[k]}`, onclick: () => store(known.points.filter((_, other) => other !== k), known.names.filter((_, other) => other !== k)) }, 'Take away')])) : '',
    known.points.length === 1 ? el('p', { class: 'muted small' }, 'Two points at least are needed.') : '');
  }

  async function store(points, names) {
    const path = valueOf(draft.text, 'control_points') || draft.nameOf('control_points');
    await draft.editFile(path, pointsText({ unit: unit.value, points, names }), (text) => withPath(text, 'control_points', points.length > 0 ? path : null));
  }

  form.addEventListener('submit', (event) => {
    event.preventDefault();
    if (!place) { say('Click the place in the mesh first.', 'warn'); return; }
    const values = [...place, ...inputs.map((input) => input.valueAsNumber)];
    const called = name.value.trim() || `point ${known.points.length + 1}`;
    place = null;
    name.value = '';
    store([...known.points, values], [...known.names, called]);
  });

  return {
    root,
    use() { root.open = true; },
    take({ x_m: x, y_m: y, z_m: z }) {
      if (z === null) { say('A place of the mesh is wanted: nothing lies there.', 'warn'); return; }
      place = [x, y, z];
      showPlace();
      inputs[0].focus();
    },
    async refresh() {
      const path = draft.id === null ? undefined : valueOf(draft.text, 'control_points'), read = path ? await draft.read(path) : null;
      try {
        known = read === null ? { unit: unit.value || 'metres', points: [], names: [] } : pointsOf(read);
      } catch (error) {
        known = { unit: 'metres', points: [], names: [] };
        say(`${path}: ${error.message}`, 'bad');
      }
      fill();
    },
  };
}
