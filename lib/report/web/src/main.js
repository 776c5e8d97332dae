// The page of a validation report: reads the data, lays out the sections, links the views.
import { el, placeButton, table } from './dom.js';
import { metres, mm, show } from './format.js';
import { readData, unpackDetail, unpackSheet } from './data.js';
import { makeState } from './state.js';
import { wishOf } from './gestures.js';
import { followHash, hashOf } from './link.js';
import { accept, makeCut, makeMeasure, numberBox, typed } from './places.js';
import { makePlan } from './plan.js';
import { makeScene } from './scene.js';
import { makeSurface } from './surface.js';
import { refreshCharts } from './charts.js';
import { alongU, errors, extraSections, health, kerbs, roughness, seam } from './sections.js';

const verdicts = {
  usable: ['Usable', 'Nothing of what was looked for lies beyond its limits.'],
  usable_with_remarks: ['Usable with remarks', 'The road can be driven; look at the places below first.'],
  not_usable: ['Not usable', 'At least one fault makes the road unfit to drive on as it is.'],
};

const kinds = {
  tile_step: 'step across the road', hole: 'hole', nan_stripe: 'missing stripe', fold: 'fold', wrong_seam: 'seam', bump: 'bump', pothole: 'pothole',
  kerb_loss: 'kerb lost', deviation: 'deviation', no_reference: 'nothing to compare with', file: 'file', validation: 'the build', published: 'published',
};

function number(value, unit) {
  if (value === null) return '–';
  if (unit === 'm' && Math.abs(value) < 1) return mm(value);
  return `${show(value)}${unit === '1' ? '' : ` ${unit}`}`;
}

/// What would have been a finding: a road without any is no better than what was looked for.
function lookedFor(data) {
  const sentences = data.looked_for ?? [];
  return sentences.length === 0 ? null : el('details', { 'data-role': 'looked-for', open: data.findings.length === 0 ? '' : null },
    el('summary', {}, 'What was looked for, and the limits'), el('ul', {}, sentences.map((sentence) => el('li', {}, sentence))));
}

function findings(data, state) {
  if (data.findings.length === 0) return el('div', { class: 'panel', 'data-view': 'findings' }, el('p', {}, 'No findings.'), lookedFor(data));
  const rows = data.findings.map((finding) => el('tr', {},
    el('td', {}, el('span', { class: `tag ${finding.severity === 'error' ? 'error' : 'remark'}` }, finding.severity)),
    el('td', {}, kinds[finding.kind] ?? finding.kind),
    el('td', {}, placeButton(state, finding.u_begin_m, finding.u_end_m)),
    el('td', { class: 'number' }, number(finding.value, finding.unit)),
    el('td', { class: 'text' }, finding.text)));
  const body = el('tbody', {}, rows.slice(0, 25));
  const panel = el('div', { class: 'panel', 'data-view': 'findings' }, el('div', { class: 'scroll' }, el('table', { class: 'findings' },
    el('thead', {}, el('tr', {}, ['', 'what', 'where', '', ''].map((head) => el('th', {}, head)))), body)));
  if (rows.length > 25) {
    const more = el('button', { type: 'button', onclick: () => { more.remove(); body.append(...rows.slice(25)); } }, `Show the other ${rows.length - 25} findings`);
    panel.append(more);
  }
  panel.append(lookedFor(data) ?? '');
  return panel;
}

/// Every rule of the verdict: what is allowed, the largest that was seen, and what is left.
function rules(data, state) {
  const rows = data.rules.map((rule) => {
    const kept = rule.seen ? rule.value <= rule.limit : true;
    const shown = rule.seen ? number(rule.value, rule.unit) : rule.value > 0 ? `below ${number(rule.value, rule.unit)}` : 'none';
    const left = !rule.seen ? '' : rule.limit > 0 ? `${Math.round(100 * (1 - rule.value / rule.limit))} %` : '';
    return el('tr', {}, el('td', {}, el('span', { class: `tag ${kept ? 'kept' : 'error'}` }, kept ? 'kept' : 'broken')), el('td', {}, rule.what),
      el('td', { class: 'number' }, number(rule.limit, rule.unit)), el('td', { class: 'number' }, shown), el('td', { class: 'number' }, left),
      el('td', {}, rule.u_m === null ? '' : placeButton(state, rule.u_m, rule.u_m)));
  });
  // Side by side: all of them are seen with the map.
  const part = (some) => el('div', { class: 'scroll' }, el('table', {},
    el('thead', {}, el('tr', {}, ['', 'rule', 'limit', 'largest seen', 'left', 'where'].map((head) => el('th', {}, head)))), el('tbody', {}, some)));
  const half = Math.ceil(rows.length / 2);
  return el('div', { class: 'panel two even', 'data-view': 'rules' }, part(rows.slice(0, half)), part(rows.slice(half)));
}

/// Where to: "1406.8", or a stretch, "1400 to 1450".
function goToForm(state) {
  const box = numberBox('Go to u / m', { 'data-role': 'go-to', placeholder: 'u / m' });
  const form = el('form', { class: 'goto' }, box, el('button', { type: 'submit' }, 'Go'));
  box.addEventListener('input', () => { box.setCustomValidity(''); box.removeAttribute('aria-invalid'); });
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const ends = box.value.split(/\s+to\s+|\s*(?:\.\.|…|–)\s*/);
    const [begin, end] = ends.length === 2 ? ends.map(typed) : [accept(box, state.uBegin, state.uEnd), NaN];
    if (ends.length === 2 && begin < end && begin >= state.uBegin && end <= state.uEnd) state.goTo(begin, end);
    else if (ends.length === 2) accept(box, state.uBegin, state.uEnd);
    else if (!Number.isNaN(begin)) state.goTo(begin, begin);
  });
  return form;
}

/// Copies the address that leads to what is looked at.
function linkButton(state) {
  const button = el('button', { type: 'button', 'data-role': 'link', title: 'Copy a link to this place and view' }, 'Copy link');
  const told = (text) => { button.textContent = text; setTimeout(() => { button.textContent = 'Copy link'; }, 1500); };
  button.addEventListener('click', async () => {
    const address = location.href.replace(/#.*$/, '') + hashOf(state);
    try {
      await navigator.clipboard.writeText(address);
      told('Copied');
    } catch {
      // Browsers that keep the clipboard from pages of this kind: the address bar has the link.
      history.replaceState(null, '', hashOf(state) || '#');
      const box = el('textarea', { readonly: '', class: 'offscreen' });
      box.value = address;
      document.body.append(box);
      box.select();
      told(document.execCommand('copy') ? 'Copied' : 'See address');
      box.remove();
    }
  });
  return button;
}

/// What the keys do, shown on demand.
function keyHelp() {
  const rows = [['+  −', 'nearer, farther'], ['←  →', 'along u; the plan moves, the 3-D view turns'], ['↑  ↓', 'plan and 3-D view, once clicked'], ['0', 'the whole road'],
    ['Tab', 'from plot to plot: keys go to the one with the frame'], ['Enter', 'in a box for u and v: go there'], ['?', 'this list'],
    ['click on the plan', 'cross section there; with "Measure" on: first, then second point'], ['two fingers', 'zoom and move; one scrolls the page']];
  const help = el('div', { class: 'panel keys', 'data-role': 'keys', id: 'keys', hidden: '' }, table(null, rows.map(([key, text]) => [el('kbd', {}, key), text])));
  const button = el('button', { type: 'button', 'aria-expanded': 'false', 'aria-controls': 'keys', title: 'What the keys do' }, 'Keys');
  const toggle = () => { help.hidden = !help.hidden; button.setAttribute('aria-expanded', String(!help.hidden)); };
  button.addEventListener('click', toggle);
  addEventListener('keydown', (event) => { if (event.key === 'Escape' && !help.hidden) toggle(); });
  return { button, help, toggle };
}

async function main() {
  const data = await readData();
  document.title = `${data.title} – road report`;
  const sheet = unpackSheet(data.sheet);
  const state = makeState(data.u_begin_m, data.u_end_m, sheet.fields.some((field) => field.key === 'completeness') ? 'completeness' : 'elevation');
  const windows = data.windows.map(unpackSheet);
  const surface = makeSurface(sheet, windows, () => (data.detail ? unpackDetail(data.detail) : sheet));

  const keys = keyHelp();
  const range = el('span', { class: 'range' });
  const showRange = () => { range.textContent = `u ${metres(state.range[0])} to ${metres(state.range[1])} m`; };
  state.subscribe((what) => { if (what === 'range') showRange(); });
  showRange();
  const theme = el('button', { type: 'button', title: 'Light or dark' }, '◐');
  theme.addEventListener('click', () => {
    const root = document.documentElement;
    const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
    root.dataset.theme = dark ? 'light' : 'dark';
    state.emit('theme');
    refreshCharts();
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { state.emit('theme'); refreshCharts(); });

  const fields = el('select', { 'aria-label': 'Colour', 'data-role': 'field' }, sheet.fields.map((field) => el('option', { value: field.key }, field.name)));
  fields.value = state.field;
  fields.addEventListener('change', () => state.setField(fields.value));
  const measuring = el('button', { type: 'button', 'data-role': 'measuring', 'aria-pressed': 'false', onclick: () => state.setMeasuring(!state.measuring) }, 'Measure');
  state.subscribe((what) => { if (what === 'measuring') measuring.setAttribute('aria-pressed', String(state.measuring)); });
  const [word, sentence] = verdicts[data.verdict] ?? [data.verdict, ''];
  const errorsFound = data.findings.filter((finding) => finding.severity === 'error').length;
  const counts = data.findings.length === 0 ? '' : `${errorsFound} error${errorsFound === 1 ? '' : 's'}, ${data.findings.length - errorsFound} remark${data.findings.length - errorsFound === 1 ? '' : 's'}`;

  const factsPanel = (facts, view) => el('div', { class: 'panel', 'data-view': view }, el('dl', { class: 'facts' }, facts.map((fact) => el('div', {}, el('dt', {}, fact.name), el('dd', {}, fact.value)))));
  const section = (id, title, ...children) => el('section', { id }, el('h2', {}, title), ...children);
  document.getElementById('report').append(
    el('h1', {}, data.title),
    el('div', { class: `panel verdict ${data.verdict in verdicts ? data.verdict : ''}`, id: 'verdict', 'data-view': 'verdict' },
      el('strong', {}, word), el('span', {}, sentence), el('span', { class: 'muted' }, counts)),
    ...((data.lead ?? []).length === 0 ? [] : [factsPanel(data.lead, 'lead')]),
    el('div', { class: 'bar' },
      el('nav', {}, [['verdict', 'Verdict'], ['track', 'Track'], ['along', 'Along u'], ['errors', 'Errors'], ['kerbs', 'Kerbs'], ['roughness', 'Roughness'], ['health', 'File']]
        .map(([id, text]) => el('a', { href: `#${id}` }, text))),
      range, goToForm(state), el('button', { type: 'button', 'data-role': 'reset', onclick: () => state.reset() }, 'Whole road'), linkButton(state), keys.button, theme, keys.help),
    el('div', {}, el('div', { class: 'panel', id: 'map' }, el('div', { class: 'tools' }, el('label', {}, 'Colour', fields), measuring,
      el('span', {}, 'click: cross section · drag: move · two fingers, or click and wheel: zoom')), makePlan(sheet, windows, surface, data, state)), rules(data, state)),
    findings(data, state),
    factsPanel(data.facts, 'facts'),
    section('track', 'Track',
      el('div', { class: 'panel two even' }, makeCut(surface, data, state), makeMeasure(surface, data, state)),
      el('div', { class: 'panel' }, makeScene(sheet, windows, data, state))),
    section('along', 'Along u', alongU(data, state), el('div', { class: 'panel', 'data-view': 'seam' }, seam(data, state))),
    section('errors', 'Errors', ...errors(data, state)),
    section('kerbs', 'Kerbs', kerbs(data, state)),
    section('roughness', 'Roughness', roughness(data, state)),
    ...extraSections(data),
    section('health', 'File', health(data)),
    el('footer', {}, `Written ${new Date(document.lastModified).toISOString().slice(0, 10)}. `, 'Every number of this page is in report.json; on paper the first findings, without single places and the 3-D view. Drawn with uPlot and three.js (MIT licence).'));

  // Print light, at the paper's width. Browsers lay out for paper only after
  // this event: the attribute gives the page its paper width while the charts are drawn anew.
  let themeBefore;
  addEventListener('beforeprint', () => {
    themeBefore = document.documentElement.dataset.theme;
    document.documentElement.dataset.theme = 'light';
    document.documentElement.dataset.printing = 'yes';
    state.emit('theme');
    state.emit('print');
    refreshCharts();
  });
  addEventListener('afterprint', () => {
    delete document.documentElement.dataset.printing;
    if (themeBefore === undefined) delete document.documentElement.dataset.theme;
    else document.documentElement.dataset.theme = themeBefore;
    state.emit('theme');
    refreshCharts();
  });

  // Keys that no plot took, and the address: it leads to what is looked at.
  document.addEventListener('keydown', (event) => {
    if (event.defaultPrevented || event.target !== document.body) return;
    if (event.key === '?') keys.toggle();
    const wish = wishOf(event);
    if (!wish || wish.dy) return;
    event.preventDefault();
    if (wish.reset) state.reset();
    else state.zoom(wish.zoom ?? 1, 0.25 * (wish.dx ?? 0));
  });
  let writing;
  state.subscribe((what) => {
    if (['cursor', 'theme', 'print', 'measuring'].includes(what)) return;
    clearTimeout(writing);
    writing = setTimeout(() => {
      if (hashOf(state) || location.hash.includes('=')) history.replaceState(null, '', hashOf(state) || '#');
      // Within another page (kerbstone view) it is that one's address that can be sent. To any: whoever shows this page may know what it shows.
      if (parent !== window) parent.postMessage({ kerbstoneReport: hashOf(state) }, '*');
    }, 300);
  });
  const follow = () => {
    if (!followHash(location.hash, state, sheet)) return false;
    fields.value = state.field;
    return true;
  };
  addEventListener('hashchange', follow);
  if (follow()) document.getElementById('map').scrollIntoView();
  document.documentElement.dataset.ready = 'yes';
}

main();
