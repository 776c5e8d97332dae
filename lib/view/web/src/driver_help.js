// What helps whoever drives: a speed that is held, and a line to follow, of a lap that was driven before.
import { el } from '../../../report/web/src/dom.js';
import { guesses } from './laps.js';
import { getJson, getPacked } from './server.js';

const kMostPoints = 3000;
const share = (value) => Math.min(1, Math.max(0, value));

/// Pedals that bring the car to a speed and keep it there.
export function pedalsToHold(target_mps, speed_mps) {
  const slow = target_mps - speed_mps;
  return { throttle: slow > -0.5 ? share(0.12 + 0.25 * slow) : 0, brake: share(-0.1 * (slow + 1)) };
}

/// `changed()`: another line is to be drawn; `say(text, kind)` tells what went wrong.
export function makeDriverHelp({ changed, say }) {
  let points = [];
  const target = el('input', { type: 'number', min: 0, max: 500, step: 1, placeholder: 'none', 'aria-label': 'Speed to hold, km/h', 'data-role': 'target-speed' });
  const lineBox = el('select', { 'aria-label': 'Line to follow, of a lap', 'data-role': 'racing-line' });
  lineBox.addEventListener('change', read);

  async function read() {
    points = [];
    const of = lineBox.value;
    try {
      if (of) {
        const { channels } = await getJson('log', { id: of }), [x, y] = ['x', 'y'].map((key) => channels.find((each) => guesses[key].test(each.name))?.name);
        if (!x || !y) throw new Error(`${of}: has no channels of places (x_m, y_m)`);
        const packed = await getPacked('channels', { id: of, name: [x, y] }), step = Math.max(1, Math.ceil(packed[x].length / kMostPoints));
        if (of !== lineBox.value) return;
        for (let k = 0; k < packed[x].length; k += step) if (!Number.isNaN(packed[x][k]) && !Number.isNaN(packed[y][k])) points.push([packed[x][k], packed[y][k]]);
      }
    } catch (error) {
      say(error.message, 'bad');
    }
    changed();
  }

  return {
    root: el('div', { class: 'tools' }, el('label', {}, 'Hold km/h', target), el('label', {}, 'Line', lineBox)),
    /// m/s; 0: none is held.
    target_mps: () => (target.validity.valid && target.valueAsNumber > 0 ? target.valueAsNumber / 3.6 : 0),
    /// As the sights' lines.
    lines: () => (points.length > 1 ? [{ points, colour: '--s3' }] : []),
    offer(entries) {
      const tables = entries.filter((entry) => ['table', 'log'].includes(entry.kind)), kept = lineBox.value;
      lineBox.replaceChildren(el('option', { value: '' }, 'none'), ...tables.map((entry) => el('option', { value: entry.id }, entry.id.replace(/^\d+\//, ''))));
      lineBox.value = tables.some((entry) => entry.id === kept) ? kept : '';
    },
  };
}
