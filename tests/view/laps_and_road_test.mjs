// Charts of laps and of a road's report: as SVG; what is seen of a road, in the address; times of laps.
// usage: node laps_and_road_test.mjs KERBSTONE CRGBUILD CRGDRIVE SOURCE [SCREENSHOT_DIR]; exit 77: skipped.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { check, circuitOf, end, failed, finish, launch, opened, packagesOf, run as runIn, serve } from './browser.mjs';

const [kerbstone, crgbuild, crgdrive, source, shots] = process.argv.slice(2);
const require = packagesOf(source);
const dir = mkdtempSync(join(tmpdir(), 'kerbstone-laps-'));
const run = (program, words) => runIn(program, words, dir);
run(crgbuild, ['synth', circuitOf(source), '-o', 'ring', '--step-m', '4', '-q']);
run(crgbuild, ['convert', 'ring/kerbstone-ring_truth.crg', '-o', 'other.crg', '-q']);
run(crgbuild, ['report', 'ring/kerbstone-ring_truth.crg', '-o', 'ring', '-q']);
// Two laps of a quick driver; one of a slow one; most of one, twice, which is none: it was put back before the line.
const lapTimes = {};
for (const [name, laps, grip] of [['quick', 2, '0.75'], ['slow', 1, '0.5']])
  lapTimes[name] = JSON.parse(run(crgdrive, ['lap', '--car', join(source, 'vehicles/open_wheel/vehicle.yaml'), '--road', 'ring/kerbstone-ring_truth.crg', '-o', `${name}.csv`, '--laps', String(laps), '--grip-usage', grip, '--json']).stdout).lap_s;
const slowRows = readFileSync(join(dir, 'slow.csv'), 'utf8').trim().split('\n'), head = slowRows.findIndex((row) => row.startsWith('time_s')) + 1;
const most = Math.round(0.8 * (slowRows.length - head)), again = slowRows.slice(head + 10, head + most);
writeFileSync(join(dir, 'put-back.csv'), `${[...slowRows.slice(0, head), ...again, ...again.map((row) => row.replace(/^[^,]*/, (time) => (Number(time) + 0.01 * most).toFixed(2)))].join('\n')}\n`);
// Twice the time in one recording, its square in the other: what the curves have to show.
const ramp = (of, name) => writeFileSync(join(dir, name), `time_s,speed_mps\n${Array.from({ length: 1001 }, (_, k) => `${0.01 * k},${of(0.01 * k)}`).join('\n')}\n`);
ramp((t) => 2 * t, 'ramp <b>.csv');
ramp((t) => t * t, 'square.csv');

const served = await serve(kerbstone, dir), browser = await launch(require);
let page;
try {
  const { problems, picture, until, accessible, ...rest } = await opened(browser, require, shots);
  page = rest.page;

  /// The text of a file that a button saves.
  async function saved(button) {
    await page.waitForTimeout(200);  // Chromium drops, without a word, what is saved faster than some ten files a second
    const [download] = await Promise.all([page.waitForEvent('download'), button.click()]);
    return { name: download.suggestedFilename(), text: readFileSync(await download.path(), 'utf8') };
  }
  /// Points of each line of an SVG in the units of its axes, by what its ticks say; and the words in it.
  const linesOf = (text) => page.evaluate((svg) => {
    const root = new DOMParser().parseFromString(svg, 'image/svg+xml').documentElement, scale = {};
    if (root.querySelector('parsererror')) return { wrong: root.textContent };
    for (const axis of ['x', 'y']) {
      const ticks = [...root.querySelectorAll(`[data-tick="${axis}"]`)].map((tick) => [Number(tick.textContent), Number(tick.getAttribute(axis)) - (axis === 'y' ? 4 : 0)]);
      const [[a, at], [b, to]] = [ticks[0], ticks.at(-1)];
      scale[axis] = (px) => a + ((b - a) * (px - at)) / (to - at);
    }
    return { words: root.textContent, elements: [...root.querySelectorAll('*')].map((each) => each.localName), lines: [...root.querySelectorAll('polyline')].map((line) => line.getAttribute('points').split(' ').map((point) => { const [x, y] = point.split(',').map(Number); return [scale.x(x), scale.y(y)]; })) };
  }, text);

  await page.goto(served.address);
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-tab="laps"]');
  await page.click('[data-id="0/ramp <b>.csv"]');
  await page.waitForSelector('[aria-label="Lap of 0/ramp <b>.csv"]');
  await page.click('[data-id="0/square.csv"]');
  await page.waitForSelector('[data-view="difference"] canvas');
  await picture('laps-svg');
  const curves = await saved(page.locator('[data-view="values"] [data-save="svg"]')), { words, lines, elements } = await linesOf(curves.text);
  check(curves.name.endsWith('-values.svg'), `its name: ${curves.name}`);
  check(lines?.length === 2 && words.includes('ramp <b>.csv') && words.includes('speed_mps') && !elements.includes('b'), `two lines with their names, which are text: ${words}`);
  // A pixel is 0.2 of 100, in time 0.01 s of 10.
  const far = (line, of) => Math.max(...line.map(([t, value]) => Math.abs(value - of(t))));
  check(lines && far(lines[0], (t) => 2 * t) < 0.25, `the first is twice the time: off by ${lines && far(lines[0], (t) => 2 * t)}`);
  check(lines && far(lines[1], (t) => t * t) < 0.25, `the second its square: off by ${lines && far(lines[1], (t) => t * t)}`);
  check(lines && lines.every((line) => Math.abs(line[0][0]) < 0.02 && Math.abs(line.at(-1)[0] - 10) < 0.02), 'from the first moment to the last');
  // What is in view, by keyboard: nearer to the middle.
  await page.focus('[data-view="difference"]');
  for (let k = 0; k < 3; ++k) await page.keyboard.press('+');
  await page.focus('[data-view="difference"] [data-save="svg"]');
  const [near] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  const part = await linesOf(readFileSync(await near.path(), 'utf8'));
  check(part.lines?.length === 1 && part.lines[0][0][0] > 1 && part.lines[0].at(-1)[0] < 9 && far(part.lines[0], (t) => t * t - 2 * t) < 0.25, `the difference of what is in view: ${part.lines?.[0]?.[0]} to ${part.lines?.[0]?.at(-1)}`);

  // Laps of three drives in one table, the fastest first; what they took is what the driver of each says.
  await page.click('[aria-label="Take away 0/ramp <b>.csv"]');
  await page.click('[aria-label="Take away 0/square.csv"]');
  for (const name of ['quick', 'slow', 'put-back']) {
    await page.click(`[data-id="0/${name}.csv"]`);
    await page.waitForSelector(`[aria-label="Lap of 0/${name}.csv"]`);
  }
  await page.selectOption('[data-part="laps"] [data-role="road"]', '0/ring/kerbstone-ring_truth.crg');
  await page.focus('[data-role="over"]');
  await page.selectOption('[data-role="over"]', 'u');
  await page.waitForSelector('[data-best]');
  const cells = await page.$$eval('[data-role="lap-times"] tbody tr', (each) => each.map((row) => [...row.cells].map((cell) => cell.textContent)));
  const expected = [...lapTimes.quick.map((time) => ['quick.csv', time]), ...lapTimes.slow.map((time) => ['slow.csv', time])].sort((a, b) => a[1] - b[1]);
  check(cells.length === expected.length && cells.every(([name, , time], k) => name === expected[k][0] && Math.abs(time - expected[k][1]) < 2e-3), `whole laps: ${JSON.stringify(cells)}; the driver: ${JSON.stringify(expected)}`);
  check(cells[0]?.[3] === 'best' && Math.abs(Number(cells[1]?.[3]) - (expected[1][1] - expected[0][1])) < 3e-3, 'the best is marked, the others behind it');
  await picture('lap-times');
  await accessible('lap times');

  // Road: charts of the report; pictures of points have none.
  await page.click('[data-tab="road"]');
  await page.click('[data-id="0/ring/kerbstone-ring_truth.crg"]');
  const report = page.frameLocator('iframe[data-report="0/ring/report.html"]');
  await report.locator('[data-view="curve-elevation_m"] canvas').waitFor();
  const heights = await linesOf((await saved(report.locator('[data-view="curve-elevation_m"] [data-save="svg"]'))).text), table = await saved(report.locator('[data-view="curve-elevation_m"] [data-save="csv"]'));
  const rows = table.text.trim().split('\r\n').slice(1).map((row) => row.split(',').map(Number)), heightAt = (u) => rows.reduce((best, row) => (Math.abs(row[0] - u) < Math.abs(best[0] - u) ? row : best))[1];
  const range = Math.max(...rows.map(([, z]) => z)) - Math.min(...rows.map(([, z]) => z));
  check(heights.lines?.length === 1 && far(heights.lines[0].filter((_, k) => k % 20 === 0), heightAt) < 0.02 * range, `the elevation is that of the table: off by ${heights.lines && far(heights.lines[0].filter((_, k) => k % 20 === 0), heightAt)} of ${range}`);
  check(await report.locator('[data-view="3d"] [data-save="svg"], .plan [data-save="svg"]').count() === 0, 'nothing in space as SVG');
  await accessible('laps and road');

  // What is in view of it stands in the address, and a page that is opened there shows the same.
  const shownOf = (from) => from.frameLocator('iframe').locator('[data-view="curve-elevation_m"]').evaluate((chart) => [Number(chart.dataset.uBegin), Number(chart.dataset.uEnd)]);
  await page.selectOption('[data-part="road"] [data-role="against"]', '0/other.crg');
  await page.waitForSelector('[data-compared="0/ring/kerbstone-ring_truth.crg 0/other.crg"]');
  await page.fill('[data-role="u-begin"]', '100');
  await page.keyboard.press('Tab');
  await page.fill('[data-role="u-end"]', '180');
  await page.keyboard.press('Tab');
  await until(() => decodeURIComponent(decodeURIComponent(location.hash)).includes('other.crg,100,180'));
  await report.locator('[data-view="curve-elevation_m"] canvas').waitFor();
  await report.locator('[data-view="curve-elevation_m"]').focus();
  for (const key of ['+', '+', '+', 'ArrowRight']) await page.keyboard.press(key);
  const seen = await shownOf(page);
  // The address is written when the keys rest: a slow machine may rest between two of them.
  await until((shown) => {
    const said = /u=([\d.]+),([\d.]+)/.exec(decodeURIComponent(decodeURIComponent(location.hash)));
    return said && shown.every((u, k) => Math.abs(u - said[k + 1]) < 0.01);
  }, seen);
  check(seen[1] - seen[0] > 10 && seen[1] - seen[0] < 0.6 * rows.at(-1)[0], `nearer by keyboard: ${seen}`);
  const link = page.url(), there = await page.context().newPage();
  await there.goto(link);
  await there.waitForSelector('[data-compared="0/ring/kerbstone-ring_truth.crg 0/other.crg"]');
  await there.frameLocator('iframe').locator('[data-view="curve-elevation_m"] canvas').waitFor();
  const same = await shownOf(there);
  check(same.every((u, k) => Math.abs(u - seen[k]) < 0.01), `the address shows the same stretch: ${same}, before ${seen}`);
  check(await there.inputValue('[data-role="u-begin"]') === '100' && await there.inputValue('[data-role="u-end"]') === '180', 'and the stretch that is compared');
  // A report of a stranger says what is no such address.
  for (const said of ['#<img src=x>', `#${'u'.repeat(1000)}`, 7, '#u=1,2/../../x'])
    await there.frameLocator('iframe').locator('body').evaluate((body, words) => parent.postMessage({ kerbstoneReport: words }, '*'), said);
  await there.waitForTimeout(500);
  check(there.url() === link, `it is left out: ${there.url()}`);
  await there.close();
  // The whole road again, and the address says nothing of it.
  await page.focus('[data-tab="road"]');
  await report.locator('[data-view="curve-elevation_m"]').focus();
  await page.keyboard.press('0');
  await until(() => !decodeURIComponent(decodeURIComponent(location.hash)).includes('u='));

  check(problems.length === 0, problems.join(' | '));
} catch (error) {
  failed(error);
  if (shots) await page?.screenshot({ path: join(shots, 'laps-failed.png') });
} finally {
  await browser.close();
  await end(served.server);
  rmSync(dir, { recursive: true });
}
finish();
