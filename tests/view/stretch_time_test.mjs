// How long "Stretch in view" takes, from the click to the two roads compared on the page, on the demo circuit and on tracks of torcs-data (docs/evidence.md).
// KERBSTONE_HEAVY=1; the machine should have nothing else to do.
// usage: node stretch_time_test.mjs KERBSTONE CRGBUILD SOURCE TORCS_TRACKS [MESH ...]; exit 77: skipped.
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { check, end, failed, finish, kPatience_ms, launch, packagesOf, run, serve } from './browser.mjs';

const [kerbstone, crgbuild, source, torcs, ...more] = process.argv.slice(2);
if (!process.env.KERBSTONE_HEAVY) {
  console.log('skipped: timed, takes minutes; KERBSTONE_HEAVY=1 runs it');
  process.exit(77);
}
const require = packagesOf(source);
const kMost_s = 2, kZooms = 6;

const dir = mkdtempSync(join(tmpdir(), 'kerbstone-stretch-')), shown = join(dir, 'shown');
mkdirSync(shown);

/// Folders with a mesh, a recipe and the whole road as built from it.
function prepare() {
  run(crgbuild, ['synth', join(source, 'tracks/kerbstone-ring/circuit.yaml'), '-o', join(dir, 'demo'), '-q']);
  const meshes = [join(dir, 'demo/kerbstone-ring.obj'), ...['aalborg', 'e-track-3', 'forza', 'g-track-1', 'ruudskogen', 'spring', 'wheel-2'].map((name) => join(torcs, 'road', name, `${name}.acc`)), ...more];
  const names = [];
  for (const mesh of meshes.filter(existsSync)) {
    const name = basename(mesh).replace(/\.[^.]*$/, ''), folder = join(shown, name);
    mkdirSync(folder);
    cpSync(mesh, join(folder, basename(mesh)));
    for (const beside of readdirSync(dirname(mesh))) if (beside.endsWith('.mtl')) cpSync(join(dirname(mesh), beside), join(folder, beside));
    writeFileSync(join(folder, 'track.yaml'), `mesh: ${basename(mesh)}\nname: ${name}\n`);
    const built = spawnSync(crgbuild, ['build', `${name}/track.yaml`, '-o', `out/${name}`, '-q'], { cwd: shown, encoding: 'utf8' });
    if (built.status !== 0 && built.status !== 3) console.log(`${name} is left out: ${built.stderr.trim()}`);
    else names.push(name);
  }
  return names;
}

try {
  const names = prepare(), served = await serve(kerbstone, shown), browser = await launch(require);
  try {
    const page = await (await browser.newContext({ viewport: { width: 1400, height: 900 } })).newPage();
    page.setDefaultTimeout(kPatience_ms);
    await page.goto(served.address);
    await page.waitForSelector('html[data-ready="yes"]');
    for (const name of names) {
      await page.click('[data-tab="track"]');
      await page.click(`[data-id="0/${name}/track.yaml"]`);
      await page.waitForSelector(`.stage[data-road^="0/out/${name}/"]`);
      await page.waitForFunction(() => document.querySelector('[data-part="track"] [data-role="reading"]').textContent === '');
      // In the middle of the view is the line's begin: there it is near enough to see its width.
      const [x, y] = readFileSync(join(shown, 'out', name, 'centreline.csv'), 'utf8').split('\n')[1].split(',').map(Number);
      await page.evaluate(([id, at]) => { location.hash = `${location.hash.split('/')[0]}/track/${encodeURIComponent(id)}/${encodeURIComponent(['plan', ...at].join(','))}`; }, [`0/${name}/track.yaml`, [x, y, 1.25 ** kZooms]]);
      await page.waitForTimeout(500);
      // As somebody does who looks for the lowest kerb: the recipe has changed since the whole was built.
      await page.fill('[data-role="recipe"]', `mesh: ${readFileSync(join(shown, name, 'track.yaml'), 'utf8').match(/^mesh: (.*)$/m)[1]}\nname: ${name}\nkerb_min_height_m: 0.02\n`);
      await page.click('[data-role="save"]');
      await page.waitForSelector('[data-role="recipe"][data-written="yes"]', { state: 'attached' });
      const begin = Date.now();
      await page.click('[data-role="stretch"]');
      await page.waitForSelector(`[data-compared^="0/out/stretches/${name}.crg "]`);
      const seconds = (Date.now() - begin) / 1000;
      const command = await page.evaluate(() => document.querySelector('[data-job] code').title.match(/--u-begin-m (\S+) --u-end-m (\S+)/).slice(1).map(Number));
      const [job] = await page.evaluate(async () => (await (await fetch('api/jobs', { headers: { 'X-Kerbstone-Token': location.hash.slice(1).split('/')[0] } })).json()).slice(-1));
      const text = `${name}: u ${command.map((u) => u.toFixed(0)).join(' to ')} m in ${seconds.toFixed(2)} s, of which the command ${job.seconds.toFixed(2)} s; wanted below ${kMost_s}`;
      console.log(text);
      check(seconds < kMost_s, text);
    }
  } finally {
    await browser.close();
    await end(served.server);
  }
} catch (error) {
  failed(error);
} finally {
  rmSync(dir, { recursive: true });
}
finish();
