// Times of whole laps of any recordings in one table: a person's beside those of stacks and of the built-in driver.
import { el, table } from '../../../report/web/src/dom.js';
import { fixed } from '../../../report/web/src/format.js';

const kEdge_m = 2;  // a recording that begins or ends that near to the line has the lap all the same
const kFastest_mps = 200;  // faster from row to row: it was put somewhere else
const kMostRows = 100;

/// [begin_s, end_s] of the laps that are whole, between two passes over the line. Rows without u or time (NaN) are left out.
export function wholeLaps(u, time, length, closed) {
  const laps = [];
  let line = null, before = null, last = null;  // when the line was passed; the row before, and the one before that
  const end = () => {
    // To the end of the road, as fast as between the last two rows.
    if (line === null || before === null || last === null || length - before.u > kEdge_m || before.u <= last.u) return;
    laps.push([line, before.t + ((length - before.u) * (before.t - last.t)) / (before.u - last.u)]);
  };
  for (let k = 0; k < u.length; ++k) {
    if (Number.isNaN(u[k]) || Number.isNaN(time[k])) continue;
    const now = { u: u[k], t: time[k] };
    if (before !== null && now.t === before.t) continue;
    const over = closed && before !== null && now.u < before.u - 0.5 * length, back = closed && before !== null && now.u > before.u + 0.5 * length;
    const forward = before === null ? 0 : now.u - before.u + (over ? length : back ? -length : 0);
    if (before === null || now.t < before.t || Math.abs(forward) > kFastest_mps * (now.t - before.t) + kEdge_m) {
      end();
      [line, last] = [now.u <= kEdge_m ? now.t : null, null];
    } else {
      if (over) {
        const passed = before.t + ((length - before.u) / forward) * (now.t - before.t);
        if (line !== null) laps.push([line, passed]);
        line = passed;
      } else if (back) line = null;  // backwards over the line
      last = before;
    }
    before = now;
  }
  end();
  return laps;
}

/// `recordings`: [{name, colour, laps: [[begin_s, end_s], ...]}]; the fastest first.
export function lapTable(recordings) {
  const rows = recordings.flatMap(({ name, colour, laps }) => laps.map(([begin, end], k) => ({ name, colour, number: k + 1, time: end - begin }))).sort((a, b) => a.time - b.time);
  if (rows.length === 0) return el('p', { class: 'muted small' }, 'No lap of these is whole, from the line to the line.');
  return el('div', {}, table(['whole laps', { number: 'lap' }, { number: 'time / s' }, { number: 'behind / s' }], rows.slice(0, kMostRows).map(({ name, colour, number, time }, k) => [
    el('span', k === 0 ? { 'data-best': name } : {}, el('span', { class: 'swatch', style: `background:var(${colour})` }), k === 0 ? el('strong', {}, name) : name), { number: String(number) },
    { number: k === 0 ? el('strong', {}, fixed(time, 3)) : fixed(time, 3) }, { number: k === 0 ? 'best' : fixed(time - rows[0].time, 3) }])),
  rows.length > kMostRows ? el('p', { class: 'muted small' }, `and ${rows.length - kMostRows} slower ones`) : null);
}
