// Heights of the road that was built along a line that somebody draws over it.
import { el } from '../../../report/web/src/dom.js';
import { mm, show } from '../../../report/web/src/format.js';
import { line, makeChart, plainAxes } from '../../../report/web/src/charts.js';
import { getPacked } from './server.js';

/// `sheet()`: the road that was built as the mesh's frame sees it, or null; `roadId()`: its file; `mark(points)` shows the line.
export function makeProfile({ sheet, roadId, say, mark }) {
  let from = null;
  const words = el('p', { class: 'small', role: 'status', 'data-role': 'profile' }), chart = el('div');
  const root = el('details', { hidden: '' }, el('summary', {}, 'Profile'), words, chart);

  async function draw(a, b) {
    const [[x0, y0], [x1, y1]] = [a, b].map((place) => sheet().toMap(place));
    const packed = await getPacked('profile', { id: roadId(), x0, y0, x1, y1 });
    const rows = Array.from(packed.s_m, (s, k) => [s, packed.z_m[k]]).filter(([, z]) => !Number.isNaN(z)), z = rows.map((row) => row[1]);
    root.hidden = false;
    root.open = true;
    chart.replaceChildren();
    delete words.dataset.length;
    if (z.length === 0) { words.textContent = 'No road lies below this line.'; return; }
    // A straight line through the ends of what is road: what stands out of it is read in millimetres.
    const low = Math.min(...z), high = Math.max(...z), [first, last] = [rows[0], rows.at(-1)], run = last[0] - first[0], slope = run > 0 ? (last[1] - first[1]) / run : 0;
    words.textContent = `${show(packed.head.length_m, 5, 2)} m long, of which ${show(run, 5, 2)} m road; heights ${show(low, 7, 3)} to ${show(high, 7, 3)} m, from end to end ${mm(last[1] - first[1])} (${show(100 * slope, 3)} %).`;
    Object.assign(words.dataset, { length: packed.head.length_m, slope });
    chart.append(makeChart({
      axes: plainAxes('along the line / m', 'z / m'), scales: { x: { time: false } }, cursor: { drag: { x: true, y: false } },
      series: [{ label: 'along the line / m' }, line('z / m', '--s1')],
    }, [Array.from(packed.s_m), Array.from(packed.z_m, (each) => (Number.isNaN(each) ? null : each))], 170, { view: 'line-profile', title: 'Profile' }).box);
  }

  return {
    root,
    use() { from = null; },
    /// A place of the mesh was clicked: where the line begins, or where it ends.
    async take(at) {
      if (!sheet()) { say('Build first: the profile is that of the road.', 'warn'); return; }
      if (from === null) {
        from = at;
        mark([at]);
        say('Here it begins; the next click ends it.');
        return;
      }
      const begin = from;
      from = null;
      mark([begin, at]);
      await draw(begin, at);
      say('');
    },
    /// Another road is shown.
    clear() { root.hidden = true; from = null; },
  };
}
