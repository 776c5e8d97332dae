// A road's report, and two roads compared: what crgbuild report makes, shown here.
import { el } from '../../../report/web/src/dom.js';
import { makeCompare } from './compare.js';
import { run } from './jobs.js';
import { fileAddress } from './server.js';

const kRest_ms = 300, kMostState = 400;
const folderOf = (id) => id.replace(/[^/]*$/, '');

/// What is seen of a road, as the address has it: [other road, u from, u to, what the report shows].
export const roadStateOf = (parts) => parts.map(encodeURIComponent).join(',').replace(/,+$/, '');

/// `keep(id, state)` puts what is seen into the address.
export function makeRoad({ changed, openRoad, keep }) {
  let id = null, entries = [], opens = 0;
  const note = el('span', { role: 'status', 'data-role': 'note' });
  const mesh = el('select', { 'aria-label': 'Mesh or recipe that it should follow', 'data-role': 'mesh' });
  const against = el('select', { 'aria-label': 'Another road to compare with', 'data-role': 'against' });
  const cloud = el('select', { 'aria-label': 'Cloud that it should follow', 'data-role': 'cloud' });
  const frame = el('iframe', { title: 'Report of the road', sandbox: 'allow-scripts allow-downloads' });
  const compare = makeCompare(remember);
  let inReport = '', isLoading = false;
  const root = el('div', { class: 'work road', 'data-part': 'road' },
    el('div', { class: 'tools' }, el('label', {}, 'Mesh', mesh), el('label', {}, 'Cloud', cloud), el('label', {}, 'Against', against),
      el('button', { type: 'button', 'data-role': 'report', onclick: report }, 'Make the report'),
      el('button', { type: 'button', 'data-role': 'keep', title: 'A copy to compare a later build with', onclick: keepCopy }, 'Keep a copy'), note), compare.root, frame);
  // By keys each letter and arrow chooses anew: what is read is the choice at which they rest.
  let resting = null;
  against.addEventListener('change', () => {
    clearTimeout(resting);
    resting = setTimeout(() => openRoad(id, against.value), kRest_ms);
  });

  function remember() { if (id !== null) keep(id, roadStateOf([against.value, ...compare.stretch(), inReport])); }

  // The report says what it shows. It may come from a stranger: only what is such an address counts. While another one loads, it is the old one that speaks.
  frame.addEventListener('load', () => { isLoading = false; });
  addEventListener('message', (event) => {
    const said = event.source !== null && event.source === frame.contentWindow && !isLoading ? event.data?.kerbstoneReport : undefined;
    if (typeof said !== 'string' || said.length > kMostState || !/^(#[\w=&.,%-]*)?$/.test(said) || said.slice(1) === inReport) return;
    inReport = said.slice(1);
    remember();
  });

  function show(report) {
    frame.hidden = !report;
    if (!report) { frame.removeAttribute('src'); delete frame.dataset.report; return; }
    isLoading = true;
    frame.src = fileAddress(report) + (inReport ? `#${inReport}` : '');
    frame.dataset.report = report.id;
  }

  async function report() {
    const of = id;
    note.textContent = 'Looking at the road …';
    const job = await run({ do: 'report', road: id, mesh: mesh.value, cloud: cloud.value, against: against.value }).catch((error) => ({ exit_code: 1, messages: error.message }));
    if (of !== id) return;
    note.textContent = job.exit_code === 0 || job.exit_code === 3 ? '' : job.messages;
    if (!job.result) return;
    ({ entries } = await changed());
    show(entries.find((entry) => entry.id === `0/${job.result}/report.html`));
  }

  async function keepCopy() {
    if (id === null) { note.textContent = 'Open a road first.'; return; }
    const of = id, job = await run({ do: 'keep', road: id }).catch((error) => ({ exit_code: 1, messages: error.message }));
    if (of !== id) return;
    note.textContent = job.exit_code === 0 ? `Kept as ${job.result}.` : job.messages;
    if (job.exit_code === 0) await fill();
  }

  async function fill() {
    ({ entries } = await changed());
    const kept = [mesh.value, cloud.value, against.value];
    // A list that is the same is left alone: somebody may be choosing in it.
    const choice = (select, kinds, first) => {
      const ids = ['', ...entries.filter((entry) => kinds.includes(entry.kind) && entry.id !== id).map((entry) => entry.id)];
      if (ids.join('\n') === [...select.options].map((option) => option.value).join('\n')) return;
      select.replaceChildren(...ids.map((each) => el('option', { value: each }, each === '' ? first : each.replace(/^\d+\//, ''))));
    };
    choice(mesh, ['recipe', 'mesh'], 'none');
    choice(cloud, ['scan'], 'none');
    choice(against, ['road'], 'none');
    for (const [k, select] of [mesh, cloud, against].entries()) select.value = [...select.options].some((option) => option.value === kept[k]) ? kept[k] : '';
  }

  async function open(next, state = '') {
    const turn = ++opens, [other = '', begin = '', end = '', shown = ''] = state.split(',').map(decodeURIComponent);
    clearTimeout(resting);
    id = next;
    await fill();
    if (turn !== opens) return;
    against.value = other;
    inReport = shown.length <= kMostState && /^[\w=&.,%-]*$/.test(shown) ? shown : '';
    const beside = entries.find((entry) => entry.kind === 'report' && folderOf(entry.id) === folderOf(id));
    note.textContent = beside ? '' : 'No report lies beside this road.';
    show(beside);
    await compare.show(id, against.value, [begin, end].map((u) => (Number.isFinite(Number(u)) ? u : '')));
  }
  return { root, open };
}
