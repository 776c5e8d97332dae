// The commands that run: what, how far, how they ended. One line each, the newest first.
import { el, refill } from '../../../report/web/src/dom.js';
import { fixed } from '../../../report/web/src/format.js';
import { getJson, startJob, stopJob } from './server.js';

const kShown = 150;  // characters of a command; Copy gives all
const kShort_s = 3;  // who waits for a short command waits for each look at it, too
const waiting = new Map();  // number of a job -> what to call with it when it has ended
let box, timer, shown = '', showing = 4, inLine = 0;

/// How a command ended that said nothing of it.
export const endOf = (job) => (job.exit_code > 128 ? `${job.command[0]} was ended by signal ${job.exit_code - 128}; nothing that was there has changed.` : `${job.command[0]} ended with exit code ${job.exit_code}.`);

/// As a shell takes it.
export const shellText = (words) => words.map((word) => (/^[A-Za-z0-9/._+,:=@%-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`)).join(' ');

function row(job) {
  const state = job.running ? ['', `${fixed(job.seconds, 1)} s`]
    : job.exit_code === 0 ? ['good', `done in ${fixed(job.seconds, 1)} s`]
      : job.exit_code === 3 ? ['warn', 'done, but must not be used (exit code 3)']
        : ['bad', job.exit_code > 128 ? `ended by signal ${job.exit_code - 128}` : `exit code ${job.exit_code}`];
  const command = shellText(job.command);
  const copy = el('button', { type: 'button', 'aria-label': `Copy: ${command}`, onclick: () => navigator.clipboard?.writeText(command) }, 'Copy');
  const line = el('div', { class: 'row', 'data-job': job.id, 'data-state': job.running ? 'running' : job.exit_code }, el('code', { title: command }, command.length > kShown ? `${command.slice(0, kShown)} …` : command),
    job.running && job.progress ? el('span', { class: 'muted' }, job.progress) : null, el('span', { class: state[0] }, state[1]), copy,
    job.running ? el('button', { type: 'button', onclick: () => stopJob(job.id).catch(() => {}) }, 'Stop') : null);
  const said = job.running ? '' : job.messages.trim();
  if (!said) return el('div', {}, line);
  const text = el('pre', { 'data-role': 'messages' }, said);
  return el('div', {}, line, job.exit_code === 0 ? el('details', {}, el('summary', {}, 'What it said'), text) : text);
}

function rowsOf(newest) {
  const more = el('button', { type: 'button', onclick: () => { showing = 50; look(); } }, `${newest.length - showing} more`);
  return [...newest.slice(0, showing).map(row), ...(newest.length > showing ? [more] : [])];
}

async function look() {
  clearTimeout(timer);
  timer = undefined;
  let jobs;
  try {
    jobs = await getJson('jobs');
  } catch {
    timer = setTimeout(look, 2000);  // until it answers again
    return;
  }
  const newest = [...jobs].reverse(), now = JSON.stringify([newest, showing, inLine]);
  if (now !== shown) {  // else whoever reads it would lose what was opened or marked
    shown = now;
    refill(box, ...(inLine > 0 ? [el('p', { class: 'small warn' }, inLine === 1 ? 'One more command waits for one of these to end, or to be stopped.' : `${inLine} more commands wait for one of these to end, or to be stopped.`)] : []), ...rowsOf(newest));
  }
  for (const job of jobs) {
    if (job.running || !waiting.has(job.id)) continue;
    const ended = waiting.get(job.id);
    waiting.delete(job.id);
    ended(job);
  }
  if (jobs.some((job) => job.running) || waiting.size > 0) timer = setTimeout(look, jobs.some((job) => job.running && job.seconds < kShort_s) ? 60 : 300);
}

export function makeJobs() {
  box = el('section', { class: 'jobs', 'aria-label': 'Commands', 'aria-live': 'polite' }, el('span', { class: 'muted' }, 'Commands that this page runs are shown here, to be copied.'));
  return box;
}

/// Only so many commands run at once (429). One that comes while others still read meshes waits for its turn, and the list of commands says so.
async function startWhenFree(wish) {
  let waits = false;
  try {
    while (true) {
      try {
        return await startJob(wish);
      } catch (error) {
        if (error.status !== 429) throw error;
        if (!waits) { waits = true; ++inLine; look(); }
        await new Promise((later) => { setTimeout(later, 300); });
      }
    }
  } finally {
    if (waits) --inLine;
  }
}

/// Starts a command, calls `begins` with {id, command, result}, and waits for its end: that and {exit_code, messages, ...}.
export async function run(wish, begins = () => {}) {
  const begun = await startWhenFree(wish);
  begins(begun);
  const ended = new Promise((done) => { waiting.set(begun.id, done); });
  look();
  return { ...begun, ...(await ended) };
}
