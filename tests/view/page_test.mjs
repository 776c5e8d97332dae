// Opens the page of kerbstone view in headless Chromium and does whole tasks with mouse and keyboard.
// usage: node page_test.mjs KERBSTONE CRGBUILD CRGDRIVE SOURCE [SCREENSHOT_DIR]; exit 77: skipped.
import { spawn, spawnSync } from 'node:child_process';
import { createRequire } from 'node:module';
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

/// Machines that build beside it are slow; nothing here waits for long on a calm one.
const kPatience_ms = 120000;

const [kerbstone, crgbuild, crgdrive, source, shots] = process.argv.slice(2);
const web = join(source, 'lib/report/web');
const chromiumPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
if (!chromiumPath || !existsSync(join(web, 'node_modules/axe-core'))) {
  console.log('skipped: needs chromium and the npm packages of lib/report/web (scripts/setup)');
  process.exit(77);
}
const require = createRequire(resolve(web, 'package.json'));
const { chromium } = require('playwright-core');
const axe = readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');

let failures = 0;
function check(condition, text) {
  if (!condition) {
    ++failures;
    console.error(`FAILED: ${text}`);
  }
}
function run(program, words, cwd) {
  const ran = spawnSync(program, words, { cwd, encoding: 'utf8' });
  if (ran.status !== 0) throw new Error(`${program} ${words.join(' ')}: ${ran.stderr}`);
  return ran;
}

const dir = mkdtempSync(join(tmpdir(), 'kerbstone-view-')), shown = join(dir, 'shown');
mkdirSync(join(shown, 'meshes'), { recursive: true });
run(crgbuild, ['synth', join(source, 'tracks/kerbstone-ring/circuit.yaml'), '-o', join(shown, 'meshes'), '--facet-m', '4', '-q']);
for (const name of readdirSync(join(shown, 'meshes'))) if (!/\.(obj|mtl)$/.test(name)) rmSync(join(shown, 'meshes', name), { recursive: true });
const recipeText = '# As it came.\nmesh: meshes/kerbstone-ring.obj\nname: ring\nu_step_m: 0.5\nv_step_m: 0.5\nstart_near_m: [400, 300]   # wrong: the start is at 0, 0\n';
writeFileSync(join(shown, 'track.yaml'), recipeText);
if (shots) mkdirSync(shots, { recursive: true });

async function serve() {
  const server = spawn(kerbstone, ['view', shown, '--no-open'], { stdio: ['ignore', 'pipe', 'inherit'] });
  const address = await new Promise((done, lost) => {
    let text = '';
    server.stdout.on('data', (bytes) => { text += bytes; if (text.includes('\n')) done(text.trim()); });
    server.on('exit', () => lost(new Error('kerbstone view ended')));
  });
  return { server, address };
}
let { server, address } = await serve();
const browser = await chromium.launch({
  executablePath: chromiumPath, headless: true,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--no-first-run'],
});
const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, deviceScaleFactor: shots ? 1 : 0.5 });
context.setDefaultTimeout(kPatience_ms);
const page = await context.newPage(), problems = [], elsewhere = [];
page.on('console', (message) => { if (message.type() === 'error') problems.push(message.text()); });
page.on('pageerror', (error) => problems.push(String(error.stack)));
page.on('request', (request) => { if (!request.url().startsWith(address) && !/^(data|blob|about):/.test(request.url())) elsewhere.push(request.url()); });
page.on('dialog', (dialog) => { problems.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });

const picture = async (name) => { if (shots) await page.screenshot({ path: join(shots, `${name}.png`) }); };
const recipe = () => readFileSync(join(shown, 'track.yaml'), 'utf8');
const until = (test, argument) => page.waitForFunction(test, argument, { timeout: kPatience_ms });
const said = (text) => until((word) => document.querySelector('[data-part="track"] [data-role="note"]')?.textContent.includes(word), text);
const jobsEnded = (count) => until((n) => document.querySelectorAll('[data-job]').length >= Math.min(n, 4) && !document.querySelector('[data-job][data-state="running"]'), count);
async function accessible(part) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => window.axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'], iframes: false }));
  for (const each of violations) check(false, `${part}: ${each.id}: ${each.help}: ${each.nodes.map((node) => node.html).slice(0, 3).join(' | ')}`);
}
const read = (id) => page.evaluate((which) => document.querySelector(`[data-role="${which}"]`).textContent, id);

try {
  // Track: the start, by mouse.
  await page.goto(address);
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-id="0/track.yaml"]');
  await page.waitForSelector('.stage[data-parts]');
  await until(() => document.querySelector('[data-role="facts"]')?.textContent.includes('triangles'));
  check(await page.inputValue('[data-role="recipe"]') === recipeText, 'the recipe is shown as it is');
  await picture('track');
  await accessible('track');
  await page.click('[data-tool="start"]');
  const box = await (await page.$('.stage canvas')).boundingBox();
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  await said('Saved.');
  const clicked = [await page.inputValue('[data-role="x"]'), await page.inputValue('[data-role="y"]')].map(Number);
  const line = recipe().match(/^start_near_m: \[(.*), (.*)\] {3}# wrong/m);
  check(line && Math.hypot(line[1] - clicked[0], line[2] - clicked[1]) < 0.02, `the click is in the file, its comment kept: ${recipe()}`);
  check(recipe().replace(/^start_near_m.*$/m, '') === recipeText.replace(/^start_near_m.*$/m, ''), 'nothing else of the recipe has changed');
  // The middle of the view is that of the road: the mesh of the demo reaches as far to the left as to the right of it.
  // Undo, then the same by keyboard alone.
  await page.click('[data-role="undo"]');
  await until((text) => document.querySelector('[data-role="recipe"]').value === text, recipeText);
  await said('Saved.');
  await page.waitForTimeout(200);
  check(recipe() === recipeText, 'undo gives the file back as it was');
  await page.fill('[data-role="x"]', '0');
  await page.fill('[data-role="y"]', '0');
  await page.press('[data-role="y"]', 'Enter');
  await until(() => document.querySelector('[data-role="recipe"]').value.includes('start_near_m: [0, 0]'));
  await page.waitForTimeout(200);
  check(recipe().includes('start_near_m: [0, 0]   # wrong'), 'typed coordinates set the start');
  await page.focus('.stage canvas');
  for (let k = 0; k < 3; ++k) await page.keyboard.press('ArrowRight');
  await page.click('[data-tool="look"]');
  await page.focus('.stage canvas');
  await page.keyboard.press('Enter');
  check((await read('where')).includes('x '), 'arrows and Enter pick a place');

  // An object that was taken for something else.
  await page.fill('input[aria-label="Find an object"]', 'kerb');
  await page.click('.objects tbody button >> nth=0');
  const object = (await read('chosen')).split(':')[0];
  await page.click('[data-class="runoff"]');
  await until((name) => document.querySelector('[data-role="recipe"]').value.includes(`^${name}$`), object);
  await said('Reading');
  await until(() => document.querySelector('[data-role="note"]').textContent === '');
  check(new RegExp(`name_rules:\\n  - \\{object: '\\^${object}\\$', class: runoff\\}`).test(recipe()), `the rule is in the recipe: ${recipe()}`);
  await page.fill('input[aria-label="Find an object"]', object);
  check((await page.innerText('.objects tbody')).includes('runoff'), 'and the object is what the rule says');
  await page.click('[data-role="undo"]');
  await until(() => document.querySelector('.objects tbody').textContent.includes('kerb'));
  check(!recipe().includes('name_rules'), 'undo takes the rule away, and the object is a kerb again');

  // Build by keyboard; the files are those of the command, byte for byte.
  await page.focus('[data-role="build"]');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.stage[data-road]');
  check((await page.innerText('.jobs')).includes('crgbuild build track.yaml -o out/shown'), 'the command is shown');
  await picture('built');
  run(crgbuild, ['build', 'track.yaml', '-o', 'by-hand', '-q'], shown);
  const made = readdirSync(join(shown, 'out/shown')).sort();
  check(JSON.stringify(made) === JSON.stringify(readdirSync(join(shown, 'by-hand')).sort()), `the same files: ${made}`);
  for (const name of made) {
    if (['timing.json', 'report.html', 'report.json', 'summary.json', 'manifest.json'].includes(name)) continue;  // say where they lie
    check(readFileSync(join(shown, 'out/shown', name)).equals(readFileSync(join(shown, 'by-hand', name))), `${name} is that of the command`);
  }
  rmSync(join(shown, 'by-hand'), { recursive: true });
  cpSync(join(shown, 'out/shown/ring.crg'), join(shown, 'before.crg'));

  // A guide drawn by keyboard and mouse: places on the first straight and the last corner.
  await page.click('[data-tool="guide"]');
  for (const [x, y] of [[10, 5], [60, 35], [110, 65]]) {
    await page.fill('[data-role="x"]', String(x));
    await page.fill('[data-role="y"]', String(y));
    await page.press('[data-role="y"]', 'Enter');
  }
  await page.mouse.click(box.x + 0.6 * box.width, box.y + 0.4 * box.height);
  await said('4 points');
  await page.click('[data-role="undo"]');
  await page.click('[data-role="use"]');
  await until(() => document.querySelector('[data-role="recipe"]').value.includes('guide: track.guide.csv'));
  check(readFileSync(join(shown, 'track.guide.csv'), 'utf8') === 'x_m,y_m\n10.000,5.000\n60.000,35.000\n110.000,65.000\n', 'the guide is what was drawn');
  await page.waitForTimeout(300);
  await page.click('[data-role="undo"]');
  await page.waitForTimeout(300);
  check(!recipe().includes('guide'), 'undo takes the guide away');

  // Somebody else changes the recipe meanwhile: nothing is overwritten.
  writeFileSync(join(shown, 'track.yaml'), `${recipe()}# by another program\n`);
  await page.click('[data-role="reverse"]');
  await said('has changed meanwhile');
  check(recipe().includes('by another program') && !recipe().includes('reverse'), 'what another program wrote stays');

  // A recipe that is wrong: the file and line are said.
  writeFileSync(join(shown, 'wrong.yaml'), 'mesh: meshes/kerbstone-ring.obj\nu_stp_m: 1\n');
  await page.reload();
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-id="0/wrong.yaml"]');
  await said('wrong.yaml:2');
  // A bare mesh gets a recipe.
  await page.click('[data-id="0/meshes/kerbstone-ring.obj"]');
  await page.waitForSelector('[data-role="make-recipe"]:visible');
  await page.click('[data-role="make-recipe"]');
  await until(() => document.querySelector('[data-role="recipe"]').value === 'mesh: kerbstone-ring.obj\nname: kerbstone-ring\n');
  check(existsSync(join(shown, 'meshes/kerbstone-ring.yaml')), 'a recipe lies beside the mesh');
  await page.waitForSelector('.stage[data-parts]');

  // Road: its report, and two compared.
  await page.click('[data-tab="road"]');
  await page.click('[data-id="0/out/shown/ring.crg"]');
  const report = page.frameLocator('iframe');
  await report.locator('html[data-ready="yes"]').waitFor();
  check((await report.locator('#verdict').innerText()).includes('Usable'), 'the report is shown');
  await page.click('[data-id="0/before.crg"]');
  await page.selectOption('[data-role="against"]', '0/out/shown/ring.crg');
  await page.click('[data-role="report"]');
  await page.waitForSelector('iframe[data-report="0/out/before-report/report.html"]');
  await report.locator('html[data-ready="yes"]').waitFor();
  await picture('road');
  await accessible('road');

  // Laps: two drives, and where they differ most.
  mkdirSync(join(shown, 'drives'));
  const drive = (name, usage) => run(crgdrive, ['lap', '--vehicle', join(source, 'vehicles/open_wheel/vehicle.yaml'), '--track', 'out/shown/ring.crg', '--grip-usage', usage, '-o', `drives/${name}.csv`, '-q'], shown);
  drive('a', '0.75');
  drive('b', '0.6');
  await page.reload();
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-tab="laps"]');
  await page.click('[data-id="0/drives/a.csv"]');
  await page.click('[data-id="0/drives/b.csv"]');
  await page.selectOption('[data-role="channel"]', 'vx_mps');
  await page.waitForSelector('[data-role="largest"][data-at]');
  const columns = (name) => {
    const rows = readFileSync(join(shown, `drives/${name}.csv`), 'utf8').split('\n').filter((text) => text && !text.startsWith('#')).map((text) => text.split(','));
    const at = (word) => rows[0].indexOf(word);
    return new Map(rows.slice(1).map((row) => [Number(row[at('time_s')]), Number(row[at('vx_mps')])]));
  };
  const a = columns('a'), b = columns('b');
  let largest = 0;
  for (const [time, speed] of a) if (b.has(time)) largest = Math.max(largest, Math.abs(b.get(time) - speed));
  const told = Number((await read('largest')).match(/: (-?[\d.]+)/)[1]);
  check(Math.abs(Math.abs(told) - largest) < 0.02 * largest, `the largest difference over time is ${told}, by the files ${largest}`);
  await page.selectOption('[data-role="road"]', '0/out/shown/ring.crg');
  await page.selectOption('[data-role="over"]', 'u');
  await page.waitForSelector('[data-view="delta-time"] canvas');
  const lapTimes = await page.$$eval('[aria-label^="Lap of"]', (boxes) => boxes.map((each) => each.selectedOptions[0].textContent));
  const duration = (rows) => Math.max(...rows.keys()) - Math.min(...rows.keys());
  check(Math.abs(Number(lapTimes[0].match(/\((.*) s\)/)[1]) - duration(a)) < 0.5, `the lap time is that of the file: ${lapTimes} ${duration(a)}`);
  await picture('laps');
  await accessible('laps');
  // The same by keyboard: away with the first, and back.
  await page.focus('[aria-label="Take away 0/drives/a.csv"]');
  await page.keyboard.press('Enter');
  await until(() => document.querySelectorAll('[aria-label^="Lap of"]').length === 1);

  // Live: ten seconds at full throttle by keyboard, into a file that the laps show.
  run(crgdrive, ['fmu', join(source, 'vehicles/open_wheel/vehicle.yaml'), '--track', 'out/shown/ring.crg', '-o', 'car.fmu', '-q'], shown);
  await page.reload();
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-tab="live"]');
  await page.click('[data-id="0/car.fmu"]');
  await page.selectOption('[data-part="live"] [data-role="road"]', '0/out/shown/ring.crg');
  await page.click('[data-role="start"]');
  await page.waitForSelector('[data-view="live"][data-time]');
  await page.focus('[data-view="live"] canvas');
  await page.keyboard.down('ArrowUp');
  await until(() => Number(document.querySelector('[data-view="live"]').dataset.time) > 4);
  await picture('live');
  const speed = Number(await page.getAttribute('[data-view="live"]', 'data-speed'));
  check(speed > 15 && speed < 60, `full throttle from rest makes it faster: ${speed} m/s after 4 s`);
  await page.click('[data-role="pause"]');
  await page.waitForTimeout(400);
  const paused = await page.getAttribute('[data-view="live"]', 'data-time');
  await page.waitForTimeout(400);
  check(await page.getAttribute('[data-view="live"]', 'data-time') === paused, 'a pause stops the clock');
  await page.click('[data-role="pause"]');
  await page.focus('[data-view="live"] canvas');
  await page.keyboard.down('ArrowDown');
  await page.keyboard.up('ArrowUp');
  await until(() => Number(document.querySelector('[data-view="live"]').dataset.time) > 10);
  check(Number(await page.getAttribute('[data-view="live"]', 'data-speed')) < speed, 'brakes make it slower');
  await accessible('live');
  await page.click('[data-role="end"]');
  await page.waitForSelector('[data-part="live"][data-result="out/drives/car-1.csv"]');
  const driven = readFileSync(join(shown, 'out/drives/car-1.csv'), 'utf8').trim().split('\n').filter((text) => !text.startsWith('#'));
  check(driven.length > 900 && Number(driven.at(-1).split(',')[0]) > 9.9, `the drive is in the file: ${driven.length} rows to ${driven.at(-1)}`);
  await page.click('[data-role="to-laps"]');
  await page.waitForSelector('[aria-label="Lap of 0/out/drives/car-1.csv"]');

  // Findings of crgexplain, of a stranger: what they say is text.
  mkdirSync(join(shown, 'found'));
  writeFileSync(join(shown, 'found/findings.json'), JSON.stringify({
    version: 1, verdict: 'explained', laps: 3, mismatches: [{ channel: 'ay', where: [{ u_begin_m: 100, u_end_m: 300 }], regime: 'turning left', size: -1.5, unit: 'm/s2' }],
    findings: [{ mechanism: 'road.grip', kind: 'road', physics: '<img src=x onerror="document.title=1"> less grip', equation: 'Fy = mu Fz', where: [{ u_begin_m: 2400, u_end_m: 100 }],
      parameters: [{ name: 'grip', value: 0.8, unit: '1', ci90: [0.75, 0.85] }], profile: [{ u_m: 0, value: 0.8, ci90: 0.05 }, { u_m: 100, value: 0.85, ci90: 0.05 }], rivals: [{ mechanism: 'road.banking' }], held_out: [] }],
  }));
  await page.reload();
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-tab="findings"]');
  await page.click('[data-id="0/found/findings.json"]');
  await page.waitForSelector('[data-part="findings"] [data-view="profile"] canvas');
  await page.selectOption('[data-part="findings"] [data-role="road"]', '0/out/shown/ring.crg');
  const words = await page.innerText('[data-part="findings"]');
  for (const word of ['Explained', '<img src=x', '0.75 to 0.85', 'u 2400 to 100 m', 'As good: road.banking', 'turning left']) check(words.includes(word), `findings show "${word}"`);
  check(await page.title() === 'Kerbstone', 'markup in findings is text');
  await page.click('[data-part="findings"] tbody [data-finding]');
  check(await page.$('[data-view="profile"]') === null, 'another one is chosen');
  await picture('findings');
  await accessible('findings');

  // Dark, and narrow.
  await page.click('[data-tab="track"]');
  await page.click('[aria-label="Light or dark"]');
  await page.click('[data-id="0/track.yaml"]');
  await page.waitForSelector('.stage[data-parts]');
  await picture('dark');
  await accessible('dark');
  await page.setViewportSize({ width: 420, height: 860 });
  await page.waitForTimeout(200);
  check(await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth) <= 0, 'nothing sticks out on a phone');
  await picture('phone');
  await page.setViewportSize({ width: 1400, height: 900 });
  check(elsewhere.length === 0, `nothing is fetched from elsewhere: ${elsewhere}`);
  // Refusals (4xx) are logged by the browser; nothing else may be.
  const bad = problems.filter((text) => !/the server responded with a status of 4\d\d/.test(text));
  check(bad.length === 0, `no console message: ${bad.join(' | ')}`);

  // The program ends: the page says so, and goes on when it is back at the same address.
  const [, port, token] = address.match(/:(\d+)\/(\w+)\//);
  server.kill('SIGTERM');
  await new Promise((done) => { server.on('exit', done); });
  await page.click('[data-role="look"]');
  await until(() => document.querySelector('[data-role="lost"]').textContent !== '');
  ({ server } = await (async () => {
    const again = spawn(kerbstone, ['view', shown, '--no-open', '--port', port, '--token', token], { stdio: ['ignore', 'pipe', 'inherit'] });
    await new Promise((done) => { again.stdout.once('data', done); });
    return { server: again };
  })());
  await page.click('[data-role="look"]');
  await until(() => document.querySelector('[data-role="lost"]').textContent === '');
  await jobsEnded(1);
} catch (error) {
  ++failures;
  console.error(error);
  await page.screenshot({ path: join(shots ?? dir, 'failed.png') }).catch(() => {});
} finally {
  await browser.close();
  server.kill('SIGTERM');
  if (failures === 0 || shots) rmSync(dir, { recursive: true });
}
console.log(failures === 0 ? 'passed' : `${failures} failures`);
process.exit(failures === 0 ? 0 : 1);
