// The tour of the first start: what each part is for, on the demo circuit.
import { el } from '../../../report/web/src/dom.js';
import { endOf, run } from './jobs.js';

/// `show(part, id)` opens a part; `changed()` reads the list of files again; `listing()`: what it gave last.
export function makeTour({ show, changed, listing }) {
  const press = (selector) => document.querySelector(selector)?.click();
  const steps = [
    { part: 'track', text: 'This page prepares a track: look at its mesh, say what is road, build, look again. The demo circuit is a figure of eight with a bridge, kerbs and a hairpin; its mesh is made in some seconds.',
      name: 'Make the demo circuit', act: makeDemo },
    { part: 'track', id: '0/demo/kerbstone-ring.obj', text: 'The mesh in the colours of what each object is taken for. Drag moves it, the wheel zooms, "3-D" turns it; by keyboard arrows move a cross. A recipe beside the mesh keeps what you set.',
      name: 'Make a recipe', act: async () => { if (has('0/demo/kerbstone-ring.yaml')) show('track', '0/demo/kerbstone-ring.yaml'); else press('[data-role="make-recipe"]'); } },
    { part: 'track', id: '0/demo/kerbstone-ring.yaml', text: '"Start", then a click, sets where u = 0 is: that and all else goes into the recipe, a text that you see and can change. Build makes the road; the command stands at the lower edge.',
      name: 'Build', act: async () => press('[data-role="build"]') },
    { part: 'road', id: '0/out/kerbstone-ring/kerbstone-ring.crg', text: 'The road\'s report: what is wrong and where, heights, cuts, spectrum, in space. Compare it with another build or a cloud.' },
    { part: 'laps', text: 'Laps: recordings and drives over one another, over time or along the road. `crgdrive lap` makes one.' },
    { part: 'live', text: 'Live: drive a unit by keyboard or gamepad, or look on while another program drives. `crgdrive fmu` makes a unit.' },
    { part: 'scans', text: 'Scans: clouds of a hundred million points, and how far they are from a road. That was the tour; it is behind "Tour" above.' },
  ];
  let at = 0, isBusy = false;
  const has = (id) => listing().entries.some((entry) => entry.id === id);
  const text = el('p', { 'data-role': 'tour-text', role: 'status' }), count = el('span', { class: 'muted small' });
  const button = (role, words, onclick) => el('button', { type: 'button', 'data-role': role, onclick }, words);
  const act = button('tour-act', '', async () => {
    if (isBusy) return;
    isBusy = true;
    act.disabled = true;
    await steps[at].act().finally(() => { isBusy = false; act.disabled = false; });
  });
  const back = button('tour-back', 'Back', () => go(at - 1)), next = button('tour-next', 'Next', () => (at + 1 < steps.length ? go(at + 1) : hide()));
  const box = el('section', { class: 'tour', role: 'dialog', 'aria-label': 'Tour', hidden: '' }, text, el('div', { class: 'tools' }, act, back, next, button('tour-close', 'Close', hide), count));
  box.addEventListener('keydown', (event) => { if (event.key === 'Escape') hide(); });

  async function makeDemo() {
    if (!has('0/demo/kerbstone-ring.obj')) {
      text.textContent = 'Making the mesh …';
      const job = await run({ do: 'demo' }).catch((error) => ({ exit_code: 1, messages: error.message }));
      if (job.exit_code !== 0) { text.textContent = job.messages?.trim() || endOf(job); return; }
      await changed();
    }
    go(at + 1);
  }

  function go(to) {
    at = Math.min(steps.length - 1, Math.max(0, to));
    const step = steps[at];
    text.textContent = step.text;
    act.hidden = !step.name;
    act.textContent = step.name ?? '';
    back.disabled = at === 0;
    next.textContent = at + 1 < steps.length ? 'Next' : 'Done';
    count.textContent = `${at + 1} of ${steps.length}`;
    box.dataset.step = at;
    show(step.part, step.id && has(step.id) ? step.id : undefined);
  }
  function hide() { box.hidden = true; }
  return {
    box,
    start() {
      box.hidden = false;
      steps[0].name = listing().demo === false ? undefined : 'Make the demo circuit';
      go(0);
      (act.hidden ? next : act).focus();
    },
  };
}
