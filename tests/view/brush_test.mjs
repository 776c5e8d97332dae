// Grip painted by a brush over a road that was built, by mouse; taken back by keyboard.
// usage: node brush_test.mjs KERBSTONE CRGBUILD CRGDRIVE SOURCE [SCREENSHOT_DIR]; exit 77: skipped.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { check, end, failed, finish, launch, opened, packagesOf, run as runIn, serve } from './browser.mjs';

const [kerbstone, crgbuild, crgdrive, source, shots] = process.argv.slice(2);
const require = packagesOf(source);
const dir = mkdtempSync(join(tmpdir(), 'kerbstone-brush-'));
const run = (program, words) => runIn(program, words, dir);
run(crgbuild, ['synth', join(source, 'tracks/kerbstone-ring/circuit.yaml'), '-o', 'ring', '--step-m', '4', '-q']);
writeFileSync(join(dir, 'track.yaml'), 'mesh: ring/kerbstone-ring.obj\nname: ring\nu_step_m: 0.5\nv_step_m: 0.5\nstart_near_m: [0, 0]\n');
run(crgbuild, ['build', 'track.yaml', '-o', `out/${basename(dir)}`, '-q']);

const served = await serve(kerbstone, dir), browser = await launch(require);
let page;
try {
  const { problems, picture, until, accessible, ...rest } = await opened(browser, require, shots);
  page = rest.page;

  const recipe = () => readFileSync(join(dir, 'track.yaml'), 'utf8');
  await page.goto(served.address);
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-id="0/track.yaml"]');
  await page.waitForSelector('.stage[data-road]');
  await until(() => document.querySelector('[data-role="facts"]')?.textContent.includes('triangles'));
  // A click alone paints nothing: it tells what lies there. (The hint of a tool may take a line from the picture: the brush first.)
  await page.click('[data-tool="brush"]');
  await page.waitForTimeout(300);
  const box = await (await page.$('.stage canvas')).boundingBox(), lookAt = async ([x, y]) => { await page.mouse.click(x, y); return [await page.inputValue('[data-role="x"]'), await page.inputValue('[data-role="y"]')].map(Number); };
  // Where the straight of the start is seen, and what lies there.
  const pixels = [[0.5, 0.5], [0.6, 0.4]].map(([x, y]) => [box.x + x * box.width, box.y + y * box.height]), places = [await lookAt(pixels[0]), await lookAt(pixels[1])];
  const perMetre = (pixels[1][0] - pixels[0][0]) / (places[1][0] - places[0][0]), pixelOf = ([x, y]) => [pixels[0][0] + perMetre * (x - places[0][0]), pixels[0][1] - perMetre * (y - places[0][1])];
  const ends = [pixelOf([-60, 0]), pixelOf([90, 0])], corners = [await lookAt(ends[0]), await lookAt(ends[1])];
  writeFileSync(join(dir, 'ends.csv'), `x_m,y_m\n${corners.map((corner) => corner.join(',')).join('\n')}\n`);
  run(crgbuild, ['query', `out/${basename(dir)}/ring.crg`, '--points', join(dir, 'ends.csv'), '-o', join(dir, 'uv.csv'), '-q']);
  const uv = readFileSync(join(dir, 'uv.csv'), 'utf8').trim().split('\n').slice(1).map((row) => row.split(',').slice(2, 4).map(Number));
  check(uv[0][0] > uv[1][0], `the stroke goes over the begin of the road: ${uv}`);
  check(!recipe().includes('friction'), 'clicks paint nothing');
  await page.fill('[data-role="grip"]', '0.45');
  await page.fill('[data-role="brush-width"]', '3');
  const drag = async ([from, to]) => { await page.mouse.move(...from); await page.mouse.down(); await page.mouse.move(...to, { steps: 12 }); await page.mouse.up(); };
  await drag(ends);
  await until(() => document.querySelector('[data-role="recipe"]').value.includes('friction_zones'));
  await page.waitForSelector('[data-role="recipe"]:not([data-written="no"])', { state: 'attached' });
  check(/^friction_zones: track.friction.csv\nfriction: true$/m.test(recipe()), `the zones are in the recipe: ${recipe()}`);
  const painted = readFileSync(join(dir, 'track.friction.csv'), 'utf8').trim().split('\n'), zone = painted[1].split(',').map(Number);
  // On a straight the stroke is straight: v of its ends, and half a brush beyond.
  const v = uv.map((each) => each[1]), wanted = [uv[0][0], uv[1][0], Math.min(...v) - 1.5, Math.max(...v) + 1.5, 0.45];
  check(painted.length === 2 && wanted.every((value, k) => Math.abs(value - zone[k]) < (k < 2 ? 0.05 : 0.3)), `the zone is what was painted: ${painted[1]}; wanted ${wanted}`);
  await picture('brush');
  await accessible('brush');
  // The view has stayed where it was.
  const still = await lookAt(pixels[0]);
  check(still.every((value, k) => Math.abs(value - places[0][k]) < 0.05), `painting moves no view: ${still}, before ${places[0]}`);
  await page.click('[data-tool="look"]');
  await page.keyboard.press('Control+z');
  await until(() => !document.querySelector('[data-role="recipe"]').value.includes('friction'));
  await page.waitForSelector('[data-role="recipe"]:not([data-written="no"])', { state: 'attached' });
  check(!recipe().includes('friction'), 'undo takes it away');
  // With another tool a drag moves the view and paints nothing.
  await drag(ends);
  check(!(await page.inputValue('[data-role="recipe"]')).includes('friction'), 'only the brush paints');
  check(problems.length === 0, problems.join(' | '));
} catch (error) {
  failed(error);
  if (shots) await page?.screenshot({ path: join(shots, 'brush-failed.png') });
} finally {
  await browser.close();
  await end(served.server);
  rmSync(dir, { recursive: true });
}
finish();
