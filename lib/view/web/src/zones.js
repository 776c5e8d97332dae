// Rectangles in u and v over the road that was built: kerbs that are none, kerbs that were missed, grip; and the
// kerbs that were found.
import { el, refill, table } from '../../../report/web/src/dom.js';
import { show } from '../../../report/web/src/format.js';
import { valueOf, withPath, withValue } from './recipe.js';

const fields = ['u_begin_m', 'u_end_m', 'v_begin_m', 'v_end_m'];
const kinds = {
  kerb: { key: 'kerb_zones', column: 'kerb', file: 'kerbs', says: (value) => (value === 1 ? 'kerb' : 'no kerb') },
  friction: { key: 'friction_zones', column: 'friction', file: 'friction', says: (value) => `grip ${show(value, 3)}` },
};
const kMostKerbs = 200, kMostAsked = 60;  // places of a stroke whose u and v are asked for

/// Rows of a file of zones: [u_begin, u_end, v_begin, v_end, value]. Throws where the columns are not there.
export function zonesOf(text, column) {
  const rows = text.split(/\r?\n/).filter((line) => line.trim() && !line.startsWith('#')).map((line) => line.split(',').map((cell) => cell.trim()));
  const at = [...fields, column].map((name) => (rows[0] ?? []).indexOf(name));
  if (at.includes(-1)) throw new Error(`The file of zones has no column ${[...fields, column][at.indexOf(-1)]}.`);
  return rows.slice(1).map((row) => at.map((k) => Number(row[k])));
}

/// As crgbuild reads them.
export function zonesText(zones, column) {
  return `${[...fields, column].join(',')}\n${zones.map((zone) => `${zone.map((value) => Number(value.toFixed(3))).join(',')}\n`).join('')}`;
}

/// The rectangle between two corners [u, v]; over the start of a closed road where that is the shorter way.
export function zoneBetween([u0, v0], [u1, v1], length, closed) {
  const over = closed && Math.abs(u1 - u0) > 0.5 * length, [low, high] = [Math.min(u0, u1), Math.max(u0, u1)];
  return [...(over ? [high, low] : [low, high]), Math.min(v0, v1), Math.max(v0, v1)];
}

/// What a brush that is `width_m` wide covers: `places` [[u, v], ...] in the order of the stroke; null: nothing.
export function zoneOfStroke(places, width_m, length, closed) {
  if (places.length < 2) return null;
  let [along, low, high] = [0, 0, 0];
  for (let k = 1; k < places.length; ++k) {
    let step = places[k][0] - places[k - 1][0];
    if (closed && Math.abs(step) > 0.5 * length) step -= Math.sign(step) * length;
    along += step;
    [low, high] = [Math.min(low, along), Math.max(high, along)];
  }
  if (!(high > low)) return null;
  const at = (u) => (closed ? ((u % length) + length) % length : u), v = places.map(([, each]) => each), first = places[0][0];
  return [...(high - low >= length ? [0, length] : [at(first + low), at(first + high)]), Math.min(...v) - 0.5 * width_m, Math.max(...v) + 0.5 * width_m];
}

/// `placeOf([x, y])` resolves to {u_m, v_m} on the road that was built; `sheet()` is that road or null.
export function makeZones({ draft, stage, say, placeOf, sheet }) {
  const zones = { kerb: [], friction: [] };
  let kind = 'kerb', kerbs = [], pad = [0.1, 0.1], corner = null, shown = null, refreshes = 0;
  const grip = el('input', { type: 'number', min: 0, max: 3, step: 0.05, value: 0.6, 'aria-label': 'Grip of a zone, against dry asphalt', 'data-role': 'grip' });
  const wide = el('input', { type: 'number', min: 0.1, max: 100, step: 'any', value: 2, 'aria-label': 'Width of the brush, in metres', 'data-role': 'brush-width' });
  const lowest = el('input', { type: 'number', min: 0, max: 1, step: 'any', 'aria-label': 'Kerbs lower than this are not refined, in metres', 'data-role': 'lowest' });
  const inputs = fields.map((name) => el('input', { type: 'number', step: 'any', required: '', 'aria-label': name.replace('_m', ' / m').replaceAll('_', ' '), 'data-zone': name }));
  const what = el('select', { 'aria-label': 'What the zone is', 'data-role': 'zone-kind' }, [['none', 'no kerb'], ['kerb', 'kerb'], ['friction', 'grip']].map(([value, text]) => el('option', { value }, text)));
  const list = el('div', { 'data-role': 'zones' }), found = el('div', { class: 'kerbs', 'data-role': 'kerbs', tabindex: 0, role: 'region', 'aria-label': 'Kerbs that were found' });
  const form = el('form', { class: 'tools zone' }, inputs.map((input, k) => el('label', {}, ['u from', 'to', 'v from', 'to'][k], input)), el('label', {}, 'is', what), el('button', { type: 'submit', 'data-role': 'add-zone' }, 'Add'));
  const root = el('details', { 'data-role': 'kerbs-and-grip' }, el('summary', {}, 'Kerbs and grip'),
    el('label', { class: 'small' }, 'Lowest kerb / m ', lowest), ' ', el('label', { class: 'small' }, 'Grip of a zone ', grip), ' ', el('label', { class: 'small' }, 'Brush / m ', wide), form, list, found);

  const outline = (zone) => {
    const road = sheet();
    if (!road) return [];
    const along = road.between(zone[0], zone[1]);
    return [...along.map((u) => road.at(u, zone[2])), ...along.reverse().map((u) => road.at(u, zone[3])), road.at(zone[0], zone[2])];
  };
  function draw() {
    const all = [...zones.kerb.map((zone) => [zone, zone[4] === 1 ? '--s3' : '--s2']), ...zones.friction.map((zone) => [zone, '--accent']), ...(shown ? [[shown, '--cursor']] : [])];
    stage.setZones(all.map(([zone, colour]) => ({ points: outline(zone), colour })));
  }

  const uAndV = (zone) => `u ${show(zone[0], 6, 1)} to ${show(zone[1], 6, 1)} m, v ${show(zone[2], 4, 2)} to ${show(zone[3], 4, 2)} m`;
  const look = (zone) => { shown = zone; draw(); };
  function fill() {
    const rows = Object.entries(zones).flatMap(([name, each]) => each.map((zone, k) => [el('button', { type: 'button', class: 'place', onclick: () => look(zone) }, uAndV(zone)), kinds[name].says(zone[4]),
      el('button', { type: 'button', 'aria-label': `Take away ${kinds[name].says(zone[4])}, ${uAndV(zone)}`, 'data-away': name, onclick: () => store(name, each.filter((_, other) => other !== k)) }, 'Take away')]));
    refill(list, rows.length > 0 ? table(['zone', 'is', ''], rows) : el('p', { class: 'muted small' }, 'No zones yet.'));
    found.hidden = kerbs.length === 0;
    refill(found, table(['kerbs that were found', 'height / mm', ''], kerbs.slice(0, kMostKerbs).map((kerb) => [
      el('button', { type: 'button', class: 'place', 'data-kerb': '', onclick: () => look(kerb.zone) }, uAndV(kerb.zone)), { number: show(1000 * kerb.height_m, 3) },
      el('button', { type: 'button', 'data-role': 'no-kerb', 'aria-label': `No kerb: ${uAndV(kerb.zone)}`, onclick: () => add('kerb', [kerb.zone[0] - pad[0], kerb.zone[1] + pad[0], kerb.zone[2] - pad[1], kerb.zone[3] + pad[1], 0]) }, 'No kerb')])));
    if (kerbs.length > kMostKerbs) found.append(el('p', { class: 'muted small' }, `and ${kerbs.length - kMostKerbs} more`));
  }

  async function store(name, next) {
    const { key, column, file } = kinds[name], path = valueOf(draft.text, key) || draft.nameOf(file);
    await draft.editFile(path, zonesText(next, column), (text) => {
      const with_ = withPath(text, key, next.length > 0 ? path : null);
      return name === 'friction' && next.length > 0 ? withValue(with_, 'friction', 'true') : with_;
    });
  }
  const add = (name, zone) => store(name, [...zones[name], zone]);

  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const zone = inputs.map((input) => input.valueAsNumber), is = what.value;
    if (zone[2] > zone[3]) { say('v from right to left: the first must be the smaller one.', 'warn'); return; }
    add(is === 'friction' ? 'friction' : 'kerb', [...zone, is === 'friction' ? grip.valueAsNumber : is === 'kerb' ? 1 : 0]);
  });
  lowest.addEventListener('change', () => {
    if (lowest.validity.valid) draft.edit((text) => withValue(text, 'kerb_min_height_m', lowest.value === '' ? null : String(lowest.valueAsNumber)));
  });

  return {
    root,
    /// A tool was chosen: 'none', 'kerb' or 'friction'.
    use(next) { kind = next; corner = null; what.value = next; root.open = true; },
    /// A place was clicked: the first or the second corner.
    async take(at) {
      if (!sheet()) { say('Build first: zones lie on the road.', 'warn'); return; }
      const place = await placeOf(at);
      if (!place) { say('That is not on the road.', 'warn'); return; }
      const here = [place.u_m, place.v_m];
      if (corner === null) {
        corner = here;
        [inputs[0].value, inputs[2].value] = here.map((value) => value.toFixed(2));
        say(`One corner at u ${here[0].toFixed(1)} m, v ${here[1].toFixed(1)} m; the other one closes the zone.`);
        return;
      }
      const zone = zoneBetween(corner, here, sheet().length, sheet().closed);
      corner = null;
      await add(kind === 'friction' ? 'friction' : 'kerb', [...zone, kind === 'friction' ? grip.valueAsNumber : kind === 'kerb' ? 1 : 0]);
    },
    /// A stroke of the brush over the road, [[x, y], ...]: grip from its begin to its end, half the brush beyond it on both sides.
    async paint(points) {
      if (!sheet()) { say('Build first: zones lie on the road.', 'warn'); return; }
      if (!wide.reportValidity() || !grip.reportValidity()) return;
      const step = Math.max(1, (points.length - 1) / (kMostAsked - 1)), asked = [];
      for (let k = 0; k < points.length - 0.5; k += step) asked.push(points[Math.round(k)]);
      const places = (await Promise.all(asked.map(placeOf))).filter(Boolean).map(({ u_m, v_m }) => [u_m, v_m]), zone = zoneOfStroke(places, wide.valueAsNumber, sheet().length, sheet().closed);
      if (!zone) { say('That is not along the road.', 'warn'); return; }
      await add('friction', [...zone, grip.valueAsNumber]);
    },
    /// Takes back the first corner; false: there was none.
    undo() { const had = corner !== null; corner = null; return had; },
    /// The recipe says something else now.
    async refresh() {
      const text = draft.text, turn = ++refreshes;
      if (document.activeElement !== lowest) lowest.value = valueOf(text, 'kerb_min_height_m') ?? '';  // else somebody types there
      for (const [name, { key, column }] of Object.entries(kinds)) {
        const path = draft.id === null ? undefined : valueOf(text, key), read = path ? await draft.read(path) : null;
        if (turn !== refreshes) return;  // the recipe has changed since then
        try {
          zones[name] = read === null ? [] : zonesOf(read, column);
        } catch (error) {
          zones[name] = [];
          say(`${path}: ${error.message}`, 'bad');
        }
      }
      fill();
      draw();
    },
    /// What the build's summary.json says of kerbs; null: nothing was built.
    setSummary(summary) {
      kerbs = (summary?.kerb?.kerbs ?? []).map((kerb) => ({ ...kerb, zone: [kerb.u_begin_m, kerb.u_end_m, kerb.v_begin_m, kerb.v_end_m] }));
      pad = [summary?.grid?.u_step_m ?? 0.1, summary?.grid?.v_step_max_m ?? 0.1];
      shown = null;
      fill();
      draw();
    },
  };
}
