// A unit is a program of whoever made it: before it runs for the first time, it is asked.
import { el } from '../../../report/web/src/dom.js';
import { getJson } from './server.js';

export function makeUnitQuestion() {
  let answer = null;
  const name = el('strong'), hash = el('code', { 'data-role': 'unit-hash' });
  const yes = el('button', { type: 'button', 'data-role': 'run-unit', onclick: () => answer?.(true) }, 'Run it');
  const no = el('button', { type: 'button', 'data-role': 'leave-unit', onclick: () => answer?.(false) }, 'Do not run it');
  const root = el('div', { class: 'panel', role: 'alertdialog', 'aria-label': 'Run this unit?', 'data-role': 'unit-question', hidden: '' },
    el('p', {}, name, ' is a program of whoever made it, and Start runs it on this machine. Run it only if you know where it comes from.'),
    el('p', { class: 'small' }, 'SHA-256 ', hash, '; as long as kerbstone view runs, these bytes are not asked for again.'), el('div', { class: 'tools' }, yes, no));

  return {
    root,
    /// The hash that was agreed to, now or before; null: it must not run. Throws Refused.
    async agreed(unit) {
      answer?.(false);
      const { sha256, agreed } = await getJson('unit', { id: unit });
      if (agreed) return sha256;
      name.textContent = unit.replace(/^\d+\//, '');
      hash.textContent = sha256;
      root.hidden = false;
      yes.focus();
      const said = await new Promise((done) => { answer = done; });
      answer = null;
      root.hidden = true;
      return said ? sha256 : null;
    },
    /// Another unit is looked at: what is open is answered with no.
    leave() { answer?.(false); },
  };
}
