// Parameters of a unit that may be changed while it drives: chosen before the drive, set at any time.
import { el, table, write } from '../../../report/web/src/dom.js';
import { show } from '../../../report/web/src/format.js';
import { run } from './jobs.js';
import { getBytes } from './server.js';

const kMost = 50;
const ofWeather = /^parameter\.environment\.(wind_mps|wind_heading_rad|road_grip)$/;  // these have boxes of their own

/// Of what `crgsim info --json` tells: numbers that may be set during a run.
export const tunableOf = (info) => info.variables.filter(({ name, causality, variability, type, values }) => causality === 'parameter' && variability === 'tunable' && type === 'float64' && values === 1 && !ofWeather.test(name));

/// Forward gears of its car, by their ratios; of another unit six.
export const gearsOf = (info) => info.variables.filter(({ name, start }) => /^parameter\.gearbox\.ratio_\d+$/.test(name) && Number(start) > 0).length || 6;

/// What `crgsim info --json` tells of a unit. Throws Error where it cannot be read.
export async function infoOf(unit) {
  const job = await run({ do: 'info', unit });
  if (job.exit_code !== 0) throw new Error(job.messages || 'The unit could not be read.');
  return JSON.parse(new TextDecoder().decode(await getBytes('output', { job: job.id })));
}

export function makeParameters({ say }) {
  let unit = null, known = [], of = null, isDriving = false, wanted = {};
  const rows = new Map();  // name -> {box, now, variable}, of those that were chosen
  const names = el('datalist', { id: 'tunable-parameters' });
  const pick = el('input', { list: 'tunable-parameters', placeholder: 'aero.drag …', size: 32, 'aria-label': 'Parameter to change while driving', 'data-role': 'parameter-name', spellcheck: 'false' });
  const addButton = el('button', { type: 'submit', 'data-role': 'add-parameter' }, 'Add');
  const form = el('form', { class: 'tools' }, pick, names, addButton), list = el('div', { 'data-role': 'chosen-parameters' });
  const root = el('details', { 'data-role': 'parameters' }, el('summary', {}, 'Parameters'), form, list,
    el('p', { class: 'muted small' }, 'Chosen before a drive begins; set before it or while it runs.'));

  /// The command runs once for each unit that is looked at so.
  async function read() {
    const asked = unit;
    if (asked === null || of === asked) return;
    of = asked;
    let info;
    try {
      info = await infoOf(asked);
    } catch (error) {
      if (unit !== asked) return;
      of = null;
      say(error.message, 'bad');
      return;
    }
    if (unit !== asked) return;
    known = tunableOf(info);
    names.replaceChildren(...known.map(({ name, description, unit: words }) => el('option', { value: name }, `${description}${words ? `, ${words}` : ''}`)));
    root.dataset.known = known.length;
  }
  root.addEventListener('toggle', () => { if (root.open) read(); });

  function fill() {
    list.replaceChildren(rows.size === 0 ? '' : table(['parameter', { number: 'stated' }, { number: 'now' }, 'set', ''], [...rows].map(([name, { variable, box, now }]) => [
      el('span', { title: variable.description }, `${name.replace(/^parameter\./, '')}${variable.unit && variable.unit !== '1' ? ` / ${variable.unit}` : ''}`), { number: show(Number(variable.start), 6) }, { number: now }, box,
      el('button', { type: 'button', disabled: isDriving ? '' : null, 'aria-label': `Take away ${name}`, onclick: () => { rows.delete(name); fill(); } }, '×')])));
  }

  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const variable = known.find(({ name }) => name === pick.value.trim() || name === `parameter.${pick.value.trim()}`);
    if (!variable) { say(`'${pick.value}' is no parameter of this unit that may be changed while it runs; the list beside the box has those that are.`, 'warn'); return; }
    if (rows.size === kMost) { say(`${kMost} parameters at most.`, 'warn'); return; }
    if (!rows.has(variable.name)) {
      const box = el('input', { type: 'number', step: 'any', placeholder: 'as it is', 'aria-label': `${variable.name} to set`, 'data-parameter': variable.name });
      box.addEventListener('change', () => { if (Number.isFinite(box.valueAsNumber)) wanted[variable.name] = box.valueAsNumber; });
      rows.set(variable.name, { variable, box, now: el('span', { 'data-now': variable.name }, '–') });
    }
    pick.value = '';
    fill();
  });

  return {
    root,
    /// Names, for the command that begins a drive.
    chosen: () => [...rows.keys()],
    open(next) {
      if (next !== unit) { rows.clear(); known = []; names.replaceChildren(); delete root.dataset.known; }
      unit = next;
      if (root.open) read();
      fill();
    },
    /// A drive begins or has ended. What stands in the boxes is set from its begin.
    enable(on) {
      isDriving = on;
      for (const each of [pick, addButton]) each.disabled = on;
      wanted = on ? Object.fromEntries([...rows].filter(([, { box }]) => Number.isFinite(box.valueAsNumber)).map(([name, { box }]) => [name, box.valueAsNumber])) : {};
      fill();
    },
    /// What was set since the last time.
    take() { const said = wanted; wanted = {}; return said; },
    show(now) { for (const [name, row] of rows) if (now[name] !== undefined) write(row.now, show(now[name], 6)); },
  };
}
