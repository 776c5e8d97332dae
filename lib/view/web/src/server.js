// What the page asks of the program that serves it. The token stands in the fragment of the page's address, which no browser sends, and goes into a header.

const token = /^#(\w+)(\/|$)/.exec(location.hash)?.[1] ?? '';

/// The fragment that shows these parts of the page, and the parts that the address shows now.
export const fragmentOf = (parts) => `#${[token, ...parts.map(encodeURIComponent)].join('/')}`;
export const shownParts = () => location.hash.slice(1).split('/').slice(1).map(decodeURIComponent);

export class Refused extends Error {
  constructor(status, text) {
    super(text);
    this.status = status;
  }
}

const told = new Set();
let isLost = false;

/// Calls `listener` with true when the program does not answer any more, with false when it does again.
export function onConnection(listener) {
  told.add(listener);
}

async function ask(path, options) {
  let answer;
  try {
    answer = await fetch(path, { ...options, headers: { ...options?.headers, 'X-Kerbstone-Token': token } });
  } catch {
    if (!isLost) told.forEach((listener) => listener(true));
    isLost = true;
    throw new Refused(0, 'kerbstone view does not answer; is it still running?');
  }
  if (isLost) told.forEach((listener) => listener(false));
  isLost = false;
  if (answer.ok) return answer;
  let text = `${answer.status} ${answer.statusText}`;
  try {
    text = (await answer.json()).error ?? text;
  } catch { /* no JSON: the status says it */ }
  throw new Refused(answer.status, text);
}

function address(path, query = {}) {
  const words = new URLSearchParams();
  for (const [key, value] of Object.entries(query)) for (const one of [value].flat()) words.append(key, one);
  return `api/${path}?${words}`;
}

/// Of a file of the listing, for frames and pictures; its key opens this file alone.
export const fileAddress = ({ id, key, modified_s }) => address('file', { id, key, fresh: modified_s });

export const getJson = async (path, query) => (await ask(address(path, query))).json();

export const getBytes = async (path, query) => (await ask(address(path, query))).arrayBuffer();

/// {head, name: Float64Array or Float32Array ...}
export async function getPacked(path, query) {
  const bytes = await getBytes(path, query);
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const out = { head };
  let at = 4 + length;
  for (const { name, type, count } of head.arrays) {
    out[name] = type === 'f32' ? new Float32Array(bytes, at, count) : new Float64Array(bytes, at, count);
    at += Math.ceil(out[name].byteLength / 8) * 8;
  }
  return out;
}

/// {text, mark}: what putText() wants back.
export async function getText(id) {
  const answer = await ask(address('text', { id }));
  return { text: await answer.text(), mark: answer.headers.get('ETag') };
}

/// Writes where the file is still the one of `mark`; null: where there is none. Gives the new mark.
export async function putText(id, text, mark) {
  const headers = { 'Content-Type': 'text/plain; charset=utf-8', ...(mark ? { 'If-Match': mark } : { 'If-None-Match': '*' }) };
  return (await ask(address('text', { id }), { method: 'PUT', headers, body: text })).headers.get('ETag');
}

export const startJob = async (wish) => (await ask('api/job', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(wish) })).json();

/// A command of crgsim serve to the drive that runs as this job; what it measured last.
export const tellDrive = async (job, command) => (await ask(address('live', { job }), { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(command) })).json();

/// What is measured in a run of crgsim serve --udp that another program drives.
export const watchRun = async (port) => (await ask(address('live', { watch: port }), { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: '{}' })).json();

export const stopJob = (id) => ask(address('job', { id }), { method: 'DELETE' });
