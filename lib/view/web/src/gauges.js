// Bars beside a drive: what the car does, a mark at what it was asked for, and the load of each wheel.
import { el, write } from '../../../report/web/src/dom.js';
import { fixed } from '../../../report/web/src/format.js';

export const kBrake_pa = 4e6, kMostSteer_rad = 0.3;  // full scale
const wheels = ['fl', 'fr', 'rl', 'rr'], kPaPerBar = 1e5;

/// Pairs of what is and what was asked for, undefined where it is not known: pedals 0 to 1, brake in Pa at the front left, steering in rad at the road wheels.
export function pairsOf(now, asked) {
  const told = (name) => asked?.[name] ?? now[name], steering = told('input.steering') ?? now['car.steer_command'];
  return {
    throttle: [now['car.throttle'], told('input.throttle')],
    brake: [now['wheel.fl.brake'], told('input.brake.fl')],
    steer: [now['car.steer'], steering === undefined ? undefined : steering / (now['parameter.steering.ratio'] ?? 1)],
    gear: [now['car.gear'], told('input.gear')],
  };
}

const kinds = {
  throttle: { name: 'Throttle', share: (value) => value, text: (value) => fixed(100 * value, 0), unit: '%' },
  brake: { name: 'Brake', share: (value) => value / kBrake_pa, text: (value) => fixed(value / kPaPerBar, 0), unit: 'bar' },
  // Straight ahead is the middle; left is left.
  steer: { name: 'Steering', share: (value) => 0.5 - (0.5 * value) / kMostSteer_rad, text: (value) => fixed((value * 180) / Math.PI, 1), unit: '°', middle: 0.5 },
};
const percent = (share) => `${100 * Math.min(1, Math.max(0, share))}%`;

/// `show(now, asked)`: measured values by name; what was sent to the unit, or nothing where another program drives.
export function makeGauges() {
  const row = (key, name) => {
    const fill = el('div', { class: 'fill' }), mark = el('div', { class: 'mark', hidden: '' }), text = el('span', { class: 'muted' });
    return { fill, mark, text, node: el('div', { class: 'gauge', 'data-bar': key }, el('span', {}, name), el('div', { class: 'tube' }, fill, mark), text) };
  };
  const pedals = Object.fromEntries(Object.entries(kinds).map(([key, { name }]) => [key, row(key, name)]));
  const loads = Object.fromEntries(wheels.map((wheel) => [wheel, row(wheel, `Load ${wheel}`)]));
  const root = el('div', { role: 'group', 'aria-label': 'Gauges: what is, and what was asked for' }, Object.values(pedals).map((each) => each.node),
    el('p', { class: 'muted small' }, 'The bar: what is. The line across it, and the second number: what was asked for.'), Object.values(loads).map((each) => each.node));

  function show(now, asked) {
    const pairs = pairsOf(now, asked);
    for (const [key, { share, text, unit, middle = 0 }] of Object.entries(kinds)) {
      const [is, wanted] = pairs[key], { fill, mark, node, text: words } = pedals[key], at = is === undefined ? middle : Math.min(1, Math.max(0, share(is)));
      fill.style.marginLeft = percent(Math.min(at, middle));
      fill.style.width = percent(Math.abs(at - middle));
      mark.hidden = wanted === undefined;
      if (wanted !== undefined) mark.style.left = percent(share(wanted));
      write(words, `${is === undefined ? '–' : text(is)} / ${wanted === undefined ? '–' : text(wanted)} ${unit}`);
      Object.assign(node.dataset, { is: is ?? '', asked: wanted ?? '' });
    }
    const total = wheels.reduce((sum, wheel) => sum + now[`wheel.${wheel}.fz`], 0);
    for (const wheel of wheels) loads[wheel].fill.style.width = percent((2 * now[`wheel.${wheel}.fz`]) / Math.max(1, total) || 0);
    const [gear, wanted] = pairs.gear;
    return { gear: gear === undefined ? '–' : wanted === undefined || wanted === gear ? fixed(gear, 0) : `${fixed(gear, 0)}, asked for ${fixed(wanted, 0)}` };
  }
  return { root, show };
}
