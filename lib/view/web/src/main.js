// The page of kerbstone view: what lies in the folders on the left, one part beside it, the commands below.
import { el, refill } from '../../../report/web/src/dom.js';
import { refreshCharts } from '../../../report/web/src/charts.js';
import { makeFindings } from './findings.js';
import { makeJobs } from './jobs.js';
import { makeLaps } from './laps.js';
import { makeLive } from './live.js';
import { makeRoad, roadStateOf } from './road.js';
import { makeScans } from './scans.js';
import { fragmentOf, getJson, onConnection, shownParts } from './server.js';
import { makeTour } from './tour.js';
import { makeTrack } from './track.js';

const parts = { track: ['Track', ['recipe', 'mesh']], road: ['Road', ['road']], laps: ['Laps', ['log', 'table']], findings: ['Findings', ['findings']], live: ['Live', ['unit']], scans: ['Scans', ['tiles', 'scan']] };
const headings = { recipe: 'Recipes', mesh: 'Meshes', road: 'Roads', log: 'Recordings', table: 'Tables and drives', unit: 'Units', findings: 'Findings of crgexplain', tiles: 'Scans as tiles', scan: 'Clouds' };

function main() {
  let listing = { folders: [], entries: [], opened: '' }, part = 'track', opened = '', compared = '', followed = '';
  const made = {};
  async function changed() {
    listing = await getJson('list');
    fillList();
    return listing;
  }
  const show = (next, ...ids) => { location.hash = fragmentOf([next, ...ids.filter(Boolean)]); };
  // What is seen goes into the address; Back leads to what was opened before, not to every turn of the view.
  const keepOf = (name) => (id, state) => {
    // An address that is not followed yet is a click of a moment ago: what was drawn meanwhile does not take it back.
    if (location.hash !== followed || part !== name || (name !== 'laps' && opened !== id)) return;
    opened = id;
    compared = state;
    history.replaceState(null, '', fragmentOf([name, id, state]));
    followed = location.hash;
  };
  const openRoad = (id, against) => show('road', id, roadStateOf([against ?? '']));
  const track = makeTrack({ changed, entriesOf: () => listing.entries, keep: keepOf('track'), openRoad });
  const road = makeRoad({ changed, openRoad, keep: keepOf('road') });
  const laps = makeLaps({ entriesOf: () => listing.entries, keep: keepOf('laps') });
  const openLaps = (ids, state) => show('laps', [...new Set([...(state ? [] : laps.chosen()), ...ids])].map(encodeURIComponent).join(','), state);
  const live = makeLive({ changed, keep: keepOf('live'), entriesOf: () => listing.entries, openLaps });
  const findings = makeFindings({ changed, openLaps, entriesOf: () => listing.entries, keep: keepOf('findings') });
  const scans = makeScans({ changed, entriesOf: () => listing.entries, openTiles: (id) => show('scans', id), keep: keepOf('scans') });
  Object.assign(made, { scans: { ...scans, element: scans.root }, findings: { ...findings, element: findings.root }, live: { ...live, element: live.root }, track: { ...track, element: el('div', { class: 'work' }, track.root) }, road: { ...road, element: road.root }, laps: { ...laps, element: laps.root } });

  const lost = el('span', { class: 'lost', role: 'alert', 'data-role': 'lost' });
  onConnection((gone) => { lost.textContent = gone ? 'kerbstone view does not answer; trying again' : ''; });
  const tabs = Object.entries(parts).map(([key, [name]]) => el('button', { type: 'button', 'data-tab': key, onclick: () => show(key) }, name));
  const theme = el('button', { type: 'button', title: 'Light or dark', 'aria-label': 'Light or dark', onclick: () => {
    const root = document.documentElement, dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
    root.dataset.theme = dark ? 'light' : 'dark';
    refreshCharts();
    track.redraw?.();
    scans.redraw();
  } }, '◐');
  const tour = makeTour({ show, changed, listing: () => listing });
  const search = el('input', { type: 'search', placeholder: 'Find a file', 'aria-label': 'Find a file' });
  const list = el('div', { 'data-role': 'files' });
  const place = el('div', { style: 'display:contents' });
  search.addEventListener('input', fillList);

  function fillList() {
    const word = search.value.toLowerCase(), current = part === 'laps' ? laps.chosen() : [opened];
    const groups = parts[part][1].map((kind) => [kind, listing.entries.filter((entry) => entry.kind === kind && entry.id.toLowerCase().includes(word))]);
    refill(list, ...groups.filter(([, entries]) => entries.length > 0).flatMap(([kind, entries]) => [el('h2', {}, headings[kind]),
      el('ul', {}, entries.slice(0, 300).map((entry) => el('li', {}, el('button', { type: 'button', 'data-id': entry.id, 'aria-current': String(current.includes(entry.id)), onclick: () => (part === 'laps' ? laps.toggle(entry.id).then(fillList) : show(part, entry.id)) },
        entry.id.slice(entry.id.indexOf('/') + 1)))), entries.length > 300 ? el('li', { class: 'muted' }, `and ${entries.length - 300} more; search`) : null)]));
    if (list.childElementCount === 0) list.append(el('p', { class: 'muted small' }, `Nothing for this part in ${listing.folders.join(', ')}.`));
    if (listing.whole === false) list.append(el('p', { class: 'warn small' }, 'There are more files than this page lists; give a smaller folder.'));
  }

  async function follow() {
    followed = location.hash;
    const [next, file = '', other = ''] = shownParts();
    const wanted = next in parts ? next : 'track';
    if (wanted !== part || place.childElementCount === 0) {
      part = wanted;
      place.replaceChildren(made[part].element);
      for (const tab of tabs) tab.setAttribute('aria-pressed', String(tab.dataset.tab === part));
      opened = '';
      compared = '';
      if (part === 'laps') laps.refresh();
    }
    if (file && (file !== opened || other !== compared)) {
      opened = file;
      compared = other;
      await made[part].open(file, other);
    }
    fillList();
  }

  document.getElementById('view').append(
    el('header', {}, el('h1', {}, 'Kerbstone'), el('nav', { 'aria-label': 'Parts' }, tabs), lost, el('span', { style: 'flex:1' }), el('button', { type: 'button', 'data-role': 'tour', onclick: () => tour.start() }, 'Tour'), theme),
    el('aside', { 'aria-label': 'Files' }, search, list), place, makeJobs(), tour.box);
  addEventListener('hashchange', follow);
  changed().then(async () => {
    const entry = listing.entries.find((each) => each.id === listing.opened);
    const home = entry && Object.keys(parts).find((key) => parts[key][1].includes(entry.kind));
    if (!shownParts()[0] && home) history.replaceState(null, '', fragmentOf([home, entry.id]));
    await follow();
    if (!listing.entries.some((entry) => entry.kind !== 'picture')) tour.start();  // nothing is there yet: the first start
    document.documentElement.dataset.ready = 'yes';
  }).catch((error) => {
    lost.textContent = error.message;
    document.documentElement.dataset.ready = 'no';
  });
}

main();
