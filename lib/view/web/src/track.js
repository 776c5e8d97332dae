// A mesh and its recipe: look, set, build, look again.
import { el } from '../../../report/web/src/dom.js';
import { count, show } from '../../../report/web/src/format.js';
import { run } from './jobs.js';
import { valueOf, withPath, withPoint, withRoute, withRule, withValue } from './recipe.js';
import { fileAddress, getBytes, getPacked, getText, putText } from './server.js';
import { classColours, makeStage } from './stage.js';

const tools = [
  ['look', 'Look', 'a click tells what lies there'],
  ['start', 'Start', 'u = 0 where the line passes nearest to the place clicked'],
  ['near', 'Which road', 'of several separate roads the one nearest to the place clicked'],
  ['route', 'Route', 'the road is the shortest way through the places clicked, in order; end on the first to close it'],
  ['guide', 'Guide', 'what lies under the line drawn is the road'],
  ['class', 'Class', 'a click chooses the object whose class is set below'],
];
const kPatience_ms = 500;  // until a mesh is shown before it is known what its objects are
const classes = ['road', 'kerb', 'runoff', 'barrier', 'scenery'];

/// `openRoad(id)` shows a road in its own part; `changed()` reads the list of files again and resolves to it.
export function makeTrack({ openRoad, changed }) {
  let id = null, recipeId = null, mark = null, tool = 'look', points = [], part = null;
  const before = [];  // texts of the recipe, for undo
  const note = el('p', { class: 'small', role: 'status', 'data-role': 'note' });
  const say = (text, kind = 'muted') => { note.className = `small ${kind}`; note.textContent = text; };
  const recipe = el('textarea', { spellcheck: 'false', 'aria-label': 'Recipe (track.yaml)', 'data-role': 'recipe' });
  const hint = el('span', { class: 'muted' });
  const facts = el('div', { class: 'small', 'data-role': 'facts' });
  const pictures = el('div');
  const list = el('div', { class: 'objects', tabindex: 0, role: 'region', 'aria-label': 'Objects of the mesh' });
  const filter = el('input', { type: 'search', placeholder: 'Find an object', 'aria-label': 'Find an object' });
  const typedX = el('input', { type: 'number', step: 'any', 'aria-label': 'x / m', placeholder: 'x / m', 'data-role': 'x' });
  const typedY = el('input', { type: 'number', step: 'any', 'aria-label': 'y / m', placeholder: 'y / m', 'data-role': 'y' });

  const stage = makeStage((place) => take(place));

  function edit(change) {
    if (recipeId === null) { say('This mesh has no recipe yet; make one first.', 'warn'); return; }
    try {
      const next = change(recipe.value);
      if (next === recipe.value) return;
      before.push(recipe.value);
      recipe.value = next;
      save();
    } catch (error) {
      say(error.message, 'bad');
    }
  }

  let saved = '', saving = Promise.resolve();
  /// One after another: each needs the mark of the one before.
  function save() {
    const text = recipe.value, of = recipeId;
    saved = text;
    saving = saving.then(async () => {
      if (of !== recipeId) return;
      try {
        mark = await putText(of, text, mark);
        say('Saved.', 'good');
      } catch (error) {
        say(error.message, 'bad');
      }
    });
    return saving;
  }

  function take(place) {
    typedX.value = place.x_m.toFixed(2);
    typedY.value = place.y_m.toFixed(2);
    const at = [place.x_m, place.y_m];
    if (place.part) choose(place.part);
    if (tool === 'start') { edit((text) => withPoint(text, 'start_near_m', at)); stage.setMarks([at], false); }
    if (tool === 'near') { edit((text) => withPoint(text, 'near_m', at)); stage.setMarks([at], false); }
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
    list.replaceChildren(el('table', {}, el('thead', {}, el('tr', {}, ['object', 'material', 'class', 'area / m²'].map((head, k) => el('th', k === 3 ? { class: 'number' } : {}, head)))), el('tbody', {}, rows)),
      shown.length > 200 ? el('p', { class: 'muted small' }, `and ${shown.length - 200} smaller ones`) : '');
    chosen.textContent = part ? `${part.name || 'nameless'}: ${part.class}, ${show(part.area_m2, 4)} m², ${count(part.triangles)} triangles` : 'No object chosen.';
    for (const button of classButtons) button.disabled = !part || !(part.name || part.material);
  }
  filter.addEventListener('input', fillList);

  const chosen = el('p', { class: 'small', 'data-role': 'chosen' });
  const classButtons = classes.map((each) => el('button', { type: 'button', 'data-class': each, onclick: () => {
    edit((text) => (part.name ? withRule(text, 'object', part.name, each) : withRule(text, 'material', part.material, each)));
    saving.then(look);
  } }, el('span', { class: 'swatch', style: `background:${classColours[each]}` }), each));

  const toolButtons = tools.map(([key, name, text]) => el('button', { type: 'button', title: text, 'aria-pressed': String(key === tool), 'data-tool': key, onclick: () => {
    tool = key;
    points = [];
    stage.setMarks([], false);
    for (const button of toolButtons) button.setAttribute('aria-pressed', String(button.dataset.tool === tool));
    hint.textContent = text;
    useButton.hidden = key !== 'route' && key !== 'guide';
    useButton.textContent = key === 'route' ? 'Use route' : 'Use guide';
  } }, name));
  const useButton = el('button', { type: 'button', hidden: '', 'data-role': 'use', onclick: usePoints });

  async function usePoints() {
    if (points.length < 2) { say('Two points at least.', 'warn'); return; }
    if (tool === 'route') {
      const closed = Math.hypot(points[0][0] - points.at(-1)[0], points[0][1] - points.at(-1)[1]) < 15 && points.length > 2;
      const route = closed ? [...points.slice(0, -1), points[0]] : points;
      edit((text) => withRoute(withPath(text, 'guide', null), route));
    } else {
      const name = `${recipeId.split('/').at(-1).replace(/\.yaml$/, '')}.guide.csv`, guide = recipeId.replace(/[^/]*$/, name);
      const rows = `x_m,y_m\n${points.map(([x, y]) => `${x.toFixed(3)},${y.toFixed(3)}`).join('\n')}\n`;
      try {
        let known = null;
        try { known = (await getText(guide)).mark; } catch { /* none yet */ }
        await putText(guide, rows, known);
        edit((text) => withPath(withValue(text, 'route', null), 'guide', name));
      } catch (error) {
        say(error.message, 'bad');
        return;
      }
    }
    points = [];
    saving.then(look);
  }

  function undo() {
    if (points.length > 0) {
      points.pop();
      stage.setMarks(points, true);
    } else if (before.length > 0) {
      const left = recipe.value;
      recipe.value = before.pop();
      save();
      // What the objects are taken for has changed too.
      if (/^(name_rules|guide|route)/m.test(left) || /^(name_rules|guide|route)/m.test(recipe.value)) saving.then(look);
    } else say('Nothing to undo.');
  }

  /// The mesh, as the recipe that was saved says.
  async function look() {
    const of = id;
    say('Reading the mesh …');
    const wish = { do: 'preview', input: recipeId ?? id }, failed = (error) => ({ exit_code: 1, messages: error.message });
    let done = false;
    // Large meshes: first as they are, in grey.
    const early = setTimeout(async () => {
      const job = await run({ ...wish, raw: true }).catch(failed);
      if (of !== id || done || job.exit_code !== 0) return;
      const bytes = await getBytes('output', { job: job.id });
      if (of === id && !done) await stage.setMesh(bytes);
    }, kPatience_ms);
    const job = await run(wish).catch(failed);
    done = true;
    clearTimeout(early);
    if (of !== id) return;
    if (job.exit_code !== 0) { say(job.messages || 'The mesh could not be read.', 'bad'); return; }
    const told = await stage.setMesh(await getBytes('output', { job: job.id }));
    if (of !== id || !told) return;
    part = null;
    stage.highlight(null);
    fillList();
    facts.replaceChildren(
      el('p', {}, `${count(told.triangles_in)} triangles${told.triangles_shown < told.triangles_in ? ` (${count(told.triangles_shown)} shown)` : ''}, ${count(told.objects.length)} objects; up: ${told.up}, unit: ${told.unit}${told.told_by ? `; road told by ${told.told_by}` : ''}.`),
      told.refusal ? el('p', { class: 'bad', 'data-role': 'refusal' }, told.refusal) : '',
      told.remarks.length > 0 ? el('details', {}, el('summary', {}, told.remarks.length === 1 ? 'One remark' : `${told.remarks.length} remarks`), el('ul', {}, told.remarks.map((remark) => el('li', {}, remark)))) : '');
    say('');
  }

  async function build() {
    await saving;
    const of = id;
    say('Building …');
    const job = await run({ do: 'build', input: recipeId ?? id }).catch((error) => ({ exit_code: 1, messages: error.message }));
    if (of !== id) return;
    if (job.exit_code === 0) say('Built.', 'good');
    else say(job.messages.trim() || `crgbuild ended with exit code ${job.exit_code}.`, job.exit_code === 3 ? 'warn' : 'bad');
    if (job.result) await showResult(job.result, of);
  }

  async function showResult(result, of) {
    const { entries } = await changed(), inside = entries.filter((entry) => entry.id.startsWith(`0/${result}/`));
    const made = inside.filter((entry) => entry.kind === 'road' && !/\.(patch-\d+|friction)\.crg$/.test(entry.id)).sort((a, b) => b.modified_s - a.modified_s)[0];
    const question = inside.find((entry) => entry.id.endsWith('.question.png'));
    pictures.replaceChildren(
      made ? el('p', {}, el('button', { type: 'button', 'data-role': 'open-road', onclick: () => openRoad(made.id) }, 'Open the report of this road')) : '',
      question ? el('img', { src: fileAddress(question.id, question.modified_s), alt: 'Which road is meant: candidates with their numbers', style: 'max-width:100%' }) : '');
    if (!made) { stage.setRoad(null); return; }
    const road = await getPacked('road', { id: made.id });
    if (of !== id) return;
    stage.setRoad(road);
    stage.box.dataset.road = made.id;
  }

  const reverse = el('button', { type: 'button', 'data-role': 'reverse', onclick: () => edit((text) => withValue(text, 'reverse', valueOf(text, 'reverse') === 'true' ? 'false' : 'true')) }, 'Turn direction');
  const planButton = el('button', { type: 'button', 'aria-pressed': 'false', onclick: () => {
    const plan = planButton.getAttribute('aria-pressed') === 'true';
    planButton.setAttribute('aria-pressed', String(!plan));
    stage.setPlan(plan);
    stage.setMarks(points, true);
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

  const root = el('div', { class: 'split', 'data-part': 'track' },
    el('div', {},
      el('div', { class: 'tools', role: 'toolbar', 'aria-label': 'What a click sets' }, toolButtons, useButton, reverse, planButton,
        el('button', { type: 'button', onclick: () => stage.fit() }, 'All'), el('button', { type: 'button', 'data-role': 'undo', onclick: undo }, 'Undo')),
      stage.box,
      el('form', { class: 'tools', style: 'margin-top:6px' }, el('label', {}, 'x / m', typedX), el('label', {}, 'y / m', typedY), el('button', { type: 'submit', 'data-role': 'set' }, 'Set'), hint)),
    el('div', { class: 'side' },
      el('div', { class: 'tools' }, el('button', { type: 'button', 'data-role': 'build', onclick: build }, el('strong', {}, 'Build')),
        el('button', { type: 'button', 'data-role': 'look', onclick: look }, 'Read the mesh again'), make),
      note, pictures, el('h2', {}, 'Recipe'), recipe,
      el('div', { class: 'tools' }, el('button', { type: 'button', 'data-role': 'save', onclick: () => { before.push(saved); save(); } }, 'Save')),
      el('h2', {}, 'Mesh'), facts, el('h2', {}, 'Objects'), chosen, el('div', { class: 'tools' }, classButtons), filter, list));
  root.querySelector('form').addEventListener('submit', (event) => {
    event.preventDefault();
    const [x, y] = [typedX.valueAsNumber, typedY.valueAsNumber];
    if (Number.isFinite(x) && Number.isFinite(y)) take({ x_m: x, y_m: y, z_m: null, part: null });
  });
  root.addEventListener('keydown', (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === 'z' && event.target !== recipe) { undo(); event.preventDefault(); }
  });
  hint.textContent = tools[0][2];

  /// A recipe or a mesh.
  async function open(next) {
    id = next;
    part = null;
    stage.clear();
    before.length = 0;
    points = [];
    stage.setMarks([], false);
    stage.setRoad(null);
    delete stage.box.dataset.road;
    pictures.replaceChildren();
    facts.replaceChildren();
    recipeId = next.endsWith('.yaml') ? next : null;
    make.hidden = recipeId !== null;
    recipe.disabled = reverse.disabled = recipeId === null;
    recipe.value = '';
    if (recipeId !== null) {
      try {
        const read = await getText(recipeId);
        if (id !== next) return;
        ({ mark } = read);
        recipe.value = saved = read.text;
      } catch (error) {
        say(error.message, 'bad');
        return;
      }
    }
    fillList();
    await look();
  }
  fillList();
  return { root, open, redraw: stage.redraw };
}
