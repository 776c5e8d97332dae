// A mesh and its recipe: look, set, build, look again.
import { el, refill } from '../../../report/web/src/dom.js';
import { count, show } from '../../../report/web/src/format.js';
import { pictureButton } from '../../../report/web/src/save.js';
import { endOf, run } from './jobs.js';
import { makeDraft } from './draft.js';
import { makePoints } from './points.js';
import { makeProfile } from './profile.js';
import { valueOf, withPath, withPoint, withRoute, withRule, withValue } from './recipe.js';
import { fileAddress, getBytes, getJson, getPacked, putText } from './server.js';
import { makeSheet } from './sheet.js';
import { classColours, makeStage } from './stage.js';
import { makeZones } from './zones.js';

const tools = [
  ['look', 'Look', 'a click tells what lies there'],
  ['start', 'Start', 'u = 0 where the line passes nearest to the place clicked'],
  ['near', 'Which road', 'of several separate roads the one nearest to the place clicked'],
  ['route', 'Route', 'the road is the shortest way through the places clicked, in order; end on the first to close it'],
  ['guide', 'Guide', 'what lies under the line drawn is the road'],
  ['class', 'Class', 'a click chooses the object whose class is set below'],
  ['gap', 'Gap', 'a click on each side of a gap across the road: gaps up to that long are bridged'],
  ['kerb', 'Kerb', 'two corners of a kerb that was not found, on the road that was built'],
  ['none', 'No kerb', 'two corners of a place where there is no kerb'],
  ['friction', 'Grip', 'two corners of a place with a grip of its own'],
  ['brush', 'Grip brush', 'a drag along the road that was built gives what it passes over a grip of its own; the right button moves the view'],
  ['point', 'Control point', 'a place of the mesh that a map shows too'],
  ['profile', 'Profile', 'where a line begins and where it ends: heights of the road that was built along it'],
];
const onRoad = ['kerb', 'none', 'friction'];
const kPatience_ms = 500;  // until a mesh is shown before it is known what its objects are
const kLarge_bytes = 20e6;  // at once, where it is larger
const kPicture_ms = 300;  // a large mesh is on the page
const classes = ['road', 'kerb', 'runoff', 'barrier', 'scenery'];

/// `openRoad(id, against)` shows a road in its own part, compared with another one; `changed()` reads the list of files again and resolves to it;
/// `keep(id, state)` puts what is seen into the address.
export function makeTrack({ openRoad, changed, entriesOf, keep }) {
  let id = null, recipeId = null, shownView = '', tool = 'look', points = [], part = null, sheet = null, roadId = null, asked = 0;
  // Two lines: a mesh that has been read must not take away what was said of a change meanwhile.
  const [[note, say], [reading, sayOfMesh]] = ['note', 'reading'].map((role) => {
    const box = el('p', { class: 'small', role: 'status', 'data-role': role });
    return [box, (text, kind = 'muted') => { box.className = `small ${kind}`; box.textContent = text; }];
  });
  const draft = makeDraft(say, () => { zones.refresh(); controls.refresh(); });
  const hint = el('span', { class: 'muted' });
  const facts = el('div', { class: 'small', 'data-role': 'facts' });
  const pictures = el('div');
  const list = el('div', { class: 'objects', tabindex: 0, role: 'region', 'aria-label': 'Objects of the mesh' });
  const filter = el('input', { type: 'search', placeholder: 'Find an object', 'aria-label': 'Find an object' });
  const typedX = el('input', { type: 'number', step: 'any', 'aria-label': 'x / m', placeholder: 'x / m', 'data-role': 'x' });
  const typedY = el('input', { type: 'number', step: 'any', 'aria-label': 'y / m', placeholder: 'y / m', 'data-role': 'y' });

  const stage = makeStage((place) => take(place), () => { if (id !== null && stage.parts.length > 0) keep(id, shownView = stage.state().join(',')); });

  const zones = makeZones({ draft, stage, say, sheet: () => sheet, placeOf: async (at) => {
    const [x, y] = sheet.toMap(at), place = await getJson('place', { id: roadId, x, y });
    return place.u_m === null ? null : place;
  } });
  const controls = makePoints({ draft, say });
  const profile = makeProfile({ sheet: () => sheet, roadId: () => roadId, say, mark: (line) => stage.setMarks(line, true) });
  const { edit } = draft;

  async function take(place) {
    typedX.value = place.x_m.toFixed(2);
    typedY.value = place.y_m.toFixed(2);
    const at = [place.x_m, place.y_m];
    if (place.part && ['look', 'class'].includes(tool)) choose(place.part);
    if (tool === 'start') { edit((text) => withPoint(text, 'start_near_m', at)); stage.setMarks([at], false); }
    if (tool === 'near') { edit((text) => withPoint(text, 'near_m', at)); stage.setMarks([at], false); }
    if (tool === 'gap') {
      points.push(at);
      stage.setMarks(points, true);
      if (points.length < 2) { say('One side of the gap; now the other one.'); return; }
      const [a, b] = points.splice(0), long = Math.ceil(10 * Math.hypot(a[0] - b[0], a[1] - b[1]) + 1) / 10;
      edit((text) => withValue(text, 'bridge_gap_m', String(long)));
      draft.settled().then(look);
    }
    if (tool === 'point') {
      stage.setMarks([at], false);
      controls.take({ ...place, z_m: place.z_m ?? stage.heightAt(...at) });
    }
    if (onRoad.includes(tool) || tool === 'profile') {
      try {
        await (tool === 'profile' ? profile : zones).take(at);
      } catch (error) {
        say(error.message, 'bad');
      }
    }
    if (tool === 'route' || tool === 'guide') {
      points.push(at);
      stage.setMarks(points, true);
      say(`${points.length} points; "${tool === 'route' ? 'Use route' : 'Use guide'}" takes them.`);
    }
  }

  function choose(next) {
    part = next;
    stage.highlight(part);
    fillList();
  }

  function fillList() {
    const word = filter.value.toLowerCase();
    const shown = stage.parts.filter((each) => `${each.name} ${each.material} ${each.class}`.toLowerCase().includes(word)).sort((a, b) => b.area_m2 - a.area_m2);
    const rows = shown.slice(0, 200).map((each) => el('tr', { 'aria-selected': String(each === part) },
      el('td', {}, el('button', { type: 'button', onclick: () => choose(each) }, each.name || 'nameless')),
      el('td', {}, each.material),
      el('td', { class: 'class' }, el('span', { class: 'swatch', style: `background:${classColours[each.class]}` }), each.class),
      el('td', { class: 'number' }, count(Math.round(each.area_m2)))));
    refill(list, el('table', {}, el('thead', {}, el('tr', {}, ['object', 'material', 'class', 'area / m²'].map((head, k) => el('th', k === 3 ? { class: 'number' } : {}, head)))), el('tbody', {}, rows)),
      shown.length > 200 ? el('p', { class: 'muted small' }, `and ${shown.length - 200} smaller ones`) : '');
    chosen.textContent = part ? `${part.name || 'nameless'}: ${part.class}, ${show(part.area_m2, 4)} m², ${count(part.triangles)} triangles` : 'No object chosen.';
    for (const button of classButtons) button.disabled = !part || !(part.name || part.material);
  }
  filter.addEventListener('input', fillList);

  const chosen = el('p', { class: 'small', 'data-role': 'chosen' });
  const classButtons = classes.map((each) => el('button', { type: 'button', 'data-class': each, onclick: () => {
    edit((text) => (part.name ? withRule(text, 'object', part.name, each) : withRule(text, 'material', part.material, each)));
    draft.settled().then(look);
  } }, el('span', { class: 'swatch', style: `background:${classColours[each]}` }), each));

  const toolButtons = tools.map(([key, name, text]) => el('button', { type: 'button', title: text, 'aria-pressed': String(key === tool), 'data-tool': key, onclick: () => {
    tool = key;
    points = [];
    stage.setMarks([], false);
    for (const button of toolButtons) button.setAttribute('aria-pressed', String(button.dataset.tool === tool));
    hint.textContent = text;
    useButton.hidden = key !== 'route' && key !== 'guide';
    useButton.textContent = key === 'route' ? 'Use route' : 'Use guide';
    if (onRoad.includes(key)) zones.use(key);
    if (key === 'brush') zones.use('friction');
    stage.setBrush(key === 'brush' ? (stroke) => zones.paint(stroke).catch((error) => say(error.message, 'bad')) : null);
    if (key === 'point') controls.use();
    if (key === 'profile') profile.use();
  } }, name));
  const useButton = el('button', { type: 'button', hidden: '', 'data-role': 'use', onclick: usePoints });

  async function usePoints() {
    if (points.length < 2) { say('Two points at least.', 'warn'); return; }
    if (tool === 'route') {
      const closed = Math.hypot(points[0][0] - points.at(-1)[0], points[0][1] - points.at(-1)[1]) < 15 && points.length > 2;
      const route = closed ? [...points.slice(0, -1), points[0]] : points;
      edit((text) => withRoute(withPath(text, 'guide', null), route));
    } else {
      const name = draft.nameOf('guide');
      await draft.editFile(name, `x_m,y_m\n${points.map(([x, y]) => `${x.toFixed(3)},${y.toFixed(3)}`).join('\n')}\n`, (text) => withPath(withValue(text, 'route', null), 'guide', name));
    }
    points = [];
    draft.settled().then(look);
  }

  async function undo() {
    if (zones.undo()) { say('The first corner is taken back.'); return; }
    if (points.length > 0) {
      points.pop();
      stage.setMarks(points, true);
      return;
    }
    const left = await draft.undo(), ofMesh = (text) => (text.match(/^(name_rules|guide|route|bridge_gap_m|  - \{).*$/mg) ?? []).join('\n');
    // What the objects are taken for may have changed too.
    if (left !== null && ofMesh(left) !== ofMesh(draft.text)) await look();
  }

  /// Where this file was looked at before; else all of it.
  function lookAgain() {
    if (stage.restore(shownView.split(','))) showPlan(shownView.startsWith('plan'));
  }

  /// Size of the file that is looked at, or of the one that the recipe names; 0: not known.
  function meshBytes() {
    const named = recipeId === null ? id : new URL(valueOf(draft.text, 'mesh') ?? '', `file:///${recipeId}`).pathname.slice(1);
    return entriesOf().find((entry) => entry.id === decodeURIComponent(named))?.bytes ?? 0;
  }

  /// The mesh, as the recipe that was saved says.
  async function look() {
    const of = id;
    sayOfMesh('Reading the mesh …');
    const wish = { do: 'preview', input: recipeId ?? id }, failed = (error) => ({ exit_code: 1, messages: error.message });
    let done = false;
    const showRaw = async () => {
      const job = await run({ ...wish, raw: true }, stage.prepare).catch(failed);
      if (of !== id || done || job.exit_code !== 0) return;
      const bytes = await getBytes('output', { job: job.id });
      if (of === id && !done && await stage.setMesh(bytes, () => of === id && !done)) lookAgain();
    };
    // Large meshes: first as they are, in grey; then what their objects are, which takes ten times as long.
    let early = null;
    if (meshBytes() > kLarge_bytes) {
      await showRaw();
      await new Promise((later) => { setTimeout(later, kPicture_ms); });  // the processors draw first
    } else early = setTimeout(showRaw, kPatience_ms);
    if (of !== id) return;
    const job = await run(wish).catch(failed);
    done = true;
    clearTimeout(early);
    if (of !== id) return;
    if (job.exit_code !== 0) { sayOfMesh(job.messages || 'The mesh could not be read.', 'bad'); return; }
    const told = await stage.setMesh(await getBytes('output', { job: job.id }));
    if (of !== id || !told) return;
    lookAgain();
    part = null;
    stage.highlight(null);
    fillList();
    facts.replaceChildren(
      el('p', {}, `${count(told.triangles_in)} triangles${told.triangles_shown < told.triangles_in ? ` (${count(told.triangles_shown)} shown)` : ''}, ${count(told.objects.length)} objects; up: ${told.up}, unit: ${told.unit}${told.told_by ? `; road told by ${told.told_by}` : ''}.`),
      told.refusal ? el('p', { class: 'bad', 'data-role': 'refusal' }, told.refusal) : '',
      told.remarks.length > 0 ? el('details', {}, el('summary', {}, told.remarks.length === 1 ? 'One remark' : `${told.remarks.length} remarks`), el('ul', {}, told.remarks.map((remark) => el('li', {}, remark)))) : '');
    sayOfMesh('');
  }

  async function build() {
    await draft.settled();
    const of = id;
    say('Building …');
    const job = await run({ do: 'build', input: recipeId ?? id }).catch((error) => ({ exit_code: 1, messages: error.message }));
    if (of !== id) return;
    if (job.exit_code === 0) say('Built.', 'good');
    else say(job.exit_code > 128 ? endOf(job) : job.messages.trim() || endOf(job), job.exit_code === 3 ? 'warn' : 'bad');
    if (job.result) await showResult(job.result, of);
  }

  /// The stretch that is seen, as the recipe would have it now, beside the road that was built.
  async function buildStretch() {
    const seen = sheet?.stretchSeen(stage.seenAt), of = id, whole = roadId;
    if (!seen) { say(sheet ? 'Nothing of the road is in view.' : 'Build the whole road once; then a stretch of it takes a second or two.', 'warn'); return; }
    await draft.settled();
    say(`Building u ${seen[0].toFixed(0)} to ${seen[1].toFixed(0)} m …`);
    const job = await run({ do: 'stretch', input: recipeId ?? id, u_begin_m: seen[0], u_end_m: seen[1] }).catch((error) => ({ exit_code: 1, messages: error.message }));
    if (of !== id) return;
    if (job.exit_code !== 0) { say(job.messages || endOf(job), 'bad'); return; }
    say(`Built in ${job.seconds.toFixed(1)} s.`, 'good');
    await changed();
    openRoad(`0/${job.result}`, whole);
  }

  /// What was built, or what lies there from an earlier build. What was asked for last is shown: a list of files from before the end of a build knows no road.
  async function showResult(result, of) {
    const turn = ++asked, isPast = () => of !== id || turn !== asked;
    const { entries } = await changed(), inside = entries.filter((entry) => entry.id.startsWith(`0/${result}/`));
    const made = inside.filter((entry) => entry.kind === 'road' && !/\.(patch-\d+|friction)\.crg$/.test(entry.id)).sort((a, b) => b.modified_s - a.modified_s)[0];
    const question = inside.find((entry) => entry.id.endsWith('.question.png'));
    if (isPast()) return;
    pictures.replaceChildren(
      made ? el('p', {}, el('button', { type: 'button', 'data-role': 'open-road', onclick: () => openRoad(made.id) }, 'Open the report of this road')) : '',
      question ? el('img', { src: fileAddress(question), alt: 'Which road is meant: candidates with their numbers', style: 'max-width:100%' }) : '');
    if (!made) { setRoad(null, null, null); return; }
    const packed = await getPacked('road', { id: made.id });
    const summary = await getJson('file', { id: `0/${result}/summary.json` }).catch(() => null);
    if (isPast()) return;
    setRoad(packed, summary, made.id);
  }

  /// Of the mesh that is shown: nothing of it lies over another one. A mesh that was tilted is not where its road is.
  function setRoad(packed, summary, of) {
    sheet = packed && !summary?.align?.tilt_and_scale ? makeSheet(packed, summary?.align) : null;
    roadId = of;
    stage.setRoad(sheet ? sheet.inMesh() : null);
    if (of) stage.box.dataset.road = of; else delete stage.box.dataset.road;
    zones.setSummary(of ? summary : null);
    profile.clear();
  }

  const reverse = el('button', { type: 'button', 'data-role': 'reverse', onclick: () => edit((text) => withValue(text, 'reverse', valueOf(text, 'reverse') === 'true' ? 'false' : 'true')) }, 'Turn direction');
  const showPlan = (plan) => planButton.setAttribute('aria-pressed', String(!plan));
  const planButton = el('button', { type: 'button', 'data-role': 'three-d', 'aria-pressed': 'false', onclick: () => {
    const plan = planButton.getAttribute('aria-pressed') === 'true';
    showPlan(plan);
    stage.setPlan(plan);
    stage.setMarks(points, true);
    keep(id, shownView = stage.state().join(','));
  } }, '3-D');
  const make = el('button', { type: 'button', 'data-role': 'make-recipe', onclick: async () => {
    const file = id.split('/').at(-1), name = file.replace(/\.[^.]*$/, ''), next = id.replace(/[^/]*$/, `${name}.yaml`);
    try {
      await putText(next, withPath(withPath('', 'mesh', file), 'name', name), null);
      await changed();
      await open(next);
    } catch (error) {
      say(error.message, 'bad');
    }
  } }, 'Make a recipe');

  const grouped = (name, ...buttons) => el('span', { class: 'group', role: 'group', 'aria-label': name }, el('small', {}, name), buttons);
  const root = el('div', { class: 'split', 'data-part': 'track' },
    el('div', {},
      el('div', { class: 'tools', role: 'toolbar', 'aria-label': 'What a click sets' }, grouped('Road', ...toolButtons.slice(0, 7), reverse),
        grouped('Surface', ...toolButtons.slice(7, 11)), grouped('Measure', ...toolButtons.slice(11)), useButton, el('button', { type: 'button', 'data-role': 'undo', onclick: undo }, 'Undo'),
        grouped('View', planButton, el('button', { type: 'button', onclick: () => stage.fit() }, 'All'),
          pictureButton('track', () => ({ canvas: stage.picture(), title: id ? id.replace(/^\d+\//, '') : '' })))),
      stage.box,
      el('form', { class: 'tools', style: 'margin-top:6px' }, el('label', {}, 'x / m', typedX), el('label', {}, 'y / m', typedY), el('button', { type: 'submit', 'data-role': 'set' }, 'Set'), hint)),
    el('div', { class: 'side' },
      el('div', { class: 'tools' }, el('button', { type: 'button', 'data-role': 'build', onclick: build }, el('strong', {}, 'Build')),
        el('button', { type: 'button', 'data-role': 'stretch', title: 'Builds the part of the road that is in view and compares it with the road that was built', onclick: buildStretch }, 'Stretch in view'),
        el('button', { type: 'button', 'data-role': 'look', onclick: look }, 'Read the mesh again'), make),
      note, reading, pictures, el('h2', {}, 'Recipe'), draft.box,
      el('div', { class: 'tools' }, el('button', { type: 'button', 'data-role': 'save', onclick: () => draft.save() }, 'Save')),
      profile.root, zones.root, controls.root,
      el('h2', {}, 'Mesh'), facts, el('h2', {}, 'Objects'), chosen, el('div', { class: 'tools' }, classButtons), filter, list));
  root.querySelector('form').addEventListener('submit', (event) => {
    event.preventDefault();
    const [x, y] = [typedX.valueAsNumber, typedY.valueAsNumber];
    if (Number.isFinite(x) && Number.isFinite(y)) take({ x_m: x, y_m: y, z_m: null, part: null });
  });
  root.addEventListener('keydown', (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === 'z' && event.target !== draft.box) { undo(); event.preventDefault(); }
  });
  hint.textContent = tools[0][2];

  /// A recipe or a mesh; `view`: what to look at, as the address had it.
  async function open(next, view = '') {
    shownView = view;
    if (view !== '' && next === id && stage.parts.length > 0) { lookAgain(); return; }
    id = next;
    part = null;
    stage.clear();
    points = [];
    stage.setMarks([], false);
    setRoad(null, null, null);
    pictures.replaceChildren();
    facts.replaceChildren();
    say('');
    sayOfMesh('');
    recipeId = next.endsWith('.yaml') ? next : null;
    make.hidden = recipeId !== null;
    reverse.disabled = recipeId === null;
    if (!(await draft.open(recipeId)) || id !== next) return;
    zones.refresh();
    controls.refresh();
    fillList();
    await look();
    if (recipeId === null || id !== next) return;
    const { result } = await getJson('result', { id: recipeId });
    if (id === next) await showResult(result, next);
  }
  fillList();
  return { root, open, redraw: stage.redraw };
}
