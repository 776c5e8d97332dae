// The recipe as text and the files beside it: each change is written at once and can be taken back.
import { el } from '../../../report/web/src/dom.js';
import { getText, putText } from './server.js';

/// `say(text, kind)` tells how it went; `changed()` is called when the text has changed.
export function makeDraft(say, changed = () => {}) {
  const box = el('textarea', { spellcheck: 'false', 'aria-label': 'Recipe (track.yaml)', 'data-role': 'recipe' });
  const before = [];  // {text, file?, was?}: the recipe before, and the file's text before
  let id = null, mark = null, saved = '', working = Promise.resolve(), waiting = 0;

  /// How many changes the file does not have yet: the box shows them before they are written.
  const count = (change) => { waiting += change; box.dataset.written = waiting === 0 ? 'yes' : 'no'; };

  /// One after another: each needs the mark of the one before.
  function queue(work) {
    const of = id;
    count(1);
    working = working.then(async () => {
      try {
        if (of !== id) return;
        await work();
        say('Saved.', 'good');
      } catch (error) {
        say(error.message, 'bad');
      } finally {
        count(-1);
      }
    });
    return working;
  }

  function save() {
    const text = saved = box.value;
    changed();
    return queue(async () => { mark = await putText(id, text, mark); });
  }

  const beside = (name) => id.replace(/[^/]*$/, name);

  async function write(file, text) {
    let known = null;
    try { known = await getText(file); } catch { /* none yet */ }
    await putText(file, text, known?.mark ?? null);
    return known?.text ?? null;
  }

  const draft = {
    box,
    get text() { return box.value; },
    get id() { return id; },
    /// Resolves when all is written.
    settled: () => working,

    edit(change) {
      if (id === null) { say('This mesh has no recipe yet; make one first.', 'warn'); return; }
      try {
        const next = change(box.value);
        if (next === box.value) return;
        before.push({ text: box.value });
        box.value = next;
        save();
      } catch (error) {
        say(error.message, 'bad');
      }
    },

    /// track.guide.csv beside track.yaml, for 'guide'.
    nameOf: (kind) => `${id.split('/').at(-1).replace(/\.yaml$/, '')}.${kind}.csv`,

    /// The text of a file beside the recipe; null: none there.
    async read(name) {
      try { return (await getText(beside(name))).text; } catch { return null; }
    },

    /// Writes a file beside the recipe, then what the recipe says of it.
    async editFile(name, text, change) {
      if (id === null) { say('This mesh has no recipe yet; make one first.', 'warn'); return; }
      const file = beside(name);
      await queue(async () => {
        const was = await write(file, text), next = change(box.value);
        before.push({ text: box.value, file, was });
        if (next === box.value) return;
        box.value = saved = next;
        mark = await putText(id, next, mark);
      });
      changed();
    },

    /// The recipe before the last change, for whoever has to know what was changed; null: nothing to undo.
    async undo() {
      if (before.length === 0) { say('Nothing to undo.'); return null; }
      const { text, file, was } = before.pop(), left = box.value;
      box.value = text;
      if (text !== left) save();
      if (file && was !== null) await queue(() => write(file, was));
      await working;
      changed();
      return left;
    },

    save() { before.push({ text: saved }); return save(); },

    /// null: a mesh without a recipe. False where it cannot be read.
    async open(next) {
      id = next;
      before.length = 0;
      box.disabled = next === null;
      box.value = saved = '';
      if (next === null) return true;
      try {
        const read = await getText(next);
        if (id !== next) return false;
        ({ mark } = read);
        box.value = saved = read.text;
      } catch (error) {
        say(error.message, 'bad');
        return false;
      }
      return true;
    },
  };
  return draft;
}
