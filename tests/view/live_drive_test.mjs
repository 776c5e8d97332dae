// A drive in the page: what the gauges say of command and feedback, and parameters that are set, by keyboard; driven by a gamepad and by touch.
// usage: node live_drive_test.mjs KERBSTONE CRGBUILD CRGDRIVE SOURCE [SCREENSHOT_DIR]; exit 77: skipped.
import { createHash } from 'node:crypto';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { check, circuitOf, end, failed, finish, launch, opened, packagesOf, run as runIn, serve } from './browser.mjs';

const [kerbstone, crgbuild, crgdrive, source, shots] = process.argv.slice(2);
const require = packagesOf(source);
const dir = mkdtempSync(join(tmpdir(), 'kerbstone-live-'));
const run = (program, words) => runIn(program, words, dir);
run(crgbuild, ['synth', circuitOf(source), '-o', 'ring', '--step-m', '4', '-q']);
run(crgdrive, ['fmu', join(source, 'vehicles/open_wheel/vehicle.yaml'), '--road', 'ring/kerbstone-ring_truth.crg', '-o', 'car.fmu', '-q']);

const served = await serve(kerbstone, dir), browser = await launch(require);
let page;
try {
  const { problems, picture, until, accessible, ...rest } = await opened(browser, require, shots, { hasTouch: true });
  page = rest.page;
  // A gamepad as browsers tell of it; this machine has none.
  await page.addInitScript(() => {
    window.pad = null;
    navigator.getGamepads = () => [null, window.pad];
  });
  const picked = '[data-view="live"] canvas:not([hidden])';
  /// What a gauge says was asked for lies between these.
  const asked = (bar, low, high) => until(([name, least, most]) => { const value = document.querySelector(`[data-bar="${name}"]`).dataset.asked; return value !== undefined && Number(value) >= least && Number(value) <= most; }, [bar, low, high]);
  const is = (bar, low, high) => until(([name, least, most]) => { const value = document.querySelector(`[data-bar="${name}"]`).dataset.is; return value !== undefined && Number(value) >= least && Number(value) <= most; }, [bar, low, high]);

  await page.goto(served.address);
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-tab="live"]');
  await page.click('[data-id="0/car.fmu"]');
  // Parameters that this drive may change, by keyboard: one is set before it begins, one while it runs.
  await page.focus('[data-role="parameters"] summary');
  await page.keyboard.press('Enter');
  await page.waitForSelector('[data-role="parameters"][data-known]');
  for (const name of ['chassis.mass_kg', 'parameter.steering.ratio', 'no.such_thing']) {
    await page.fill('[data-role="parameter-name"]', name);
    await page.press('[data-role="parameter-name"]', 'Enter');
  }
  check((await page.innerText('[data-part="live"] [data-role="note"]')).includes("'no.such_thing' is no parameter"), 'what the unit has not is said');
  await page.fill('[data-parameter="parameter.chassis.mass_kg"]', '800');
  await page.keyboard.press('Tab');
  // A unit is a program: it is asked for its bytes before it runs, and once.
  await page.click('[data-role="start"]');
  await page.waitForSelector('[data-role="unit-question"]:not([hidden])');
  check(await page.innerText('[data-role="unit-hash"]') === createHash('sha256').update(readFileSync(join(dir, 'car.fmu'))).digest('hex'), 'the question names the bytes of the unit');
  await accessible('question before a unit runs');
  await page.click('[data-role="leave-unit"]');
  await until(() => document.querySelector('[data-part="live"] [data-role="note"]').textContent === 'Not started.');
  check(await page.$$eval('[data-job] code', (codes) => codes.every((code) => !code.title.includes('crgsim serve'))), 'nothing of the unit ran');
  await page.click('[data-role="start"]');
  await page.click('[data-role="run-unit"]');
  await page.waitForSelector('[data-view="live"][data-time]');

  // Command and feedback: the actuators follow what the keys ask for, and both are shown.
  await page.focus(picked);
  await page.keyboard.down('ArrowUp');
  await asked('throttle', 1, 1);
  await is('throttle', 0.95, 1);
  await page.keyboard.down('ArrowLeft');
  await asked('steer', 0.02, 0.31);
  await is('steer', 0.02, 0.31);
  const steering = await page.$eval('[data-bar="steer"]', (bar) => ({ mark: bar.querySelector('.mark').style.left, words: bar.textContent }));
  check(parseFloat(steering.mark) < 50, `left is left of the middle: ${steering.mark}`);
  check(/^Steering\d+\.\d \/ \d+\.\d °$/.test(steering.words), `both angles are told: ${steering.words}`);
  await picture('gauges');
  await page.keyboard.up('ArrowLeft');
  await page.keyboard.up('ArrowUp');
  await asked('throttle', 0, 0);
  await is('throttle', 0, 0.05);
  await page.keyboard.down('ArrowDown');
  await asked('brake', 4e6, 4e6);
  await is('brake', 3e6, 4e6);
  await page.keyboard.up('ArrowDown');
  await asked('brake', 0, 0);
  await accessible('gauges');
  const now = (name, value) => until(([of, words]) => document.querySelector(`[data-now="${of}"]`).textContent === words, [name, value]);
  await now('parameter.chassis.mass_kg', '800');
  await now('parameter.steering.ratio', '1');
  await page.fill('[data-parameter="parameter.steering.ratio"]', '2');
  await page.keyboard.press('Enter');
  await now('parameter.steering.ratio', '2');
  await page.focus(picked);
  await page.keyboard.down('ArrowLeft');
  await until(() => Number(document.querySelector('[data-bar="steer"]').dataset.asked) > 0.01);
  await asked('steer', 0.01, 0.151);  // of twice as much at the wheel
  await page.keyboard.up('ArrowLeft');
  await picture('parameters');

  // A gamepad: triggers in part, the stick to the right, which is a negative angle; near its middle it steers nothing.
  await page.fill('[data-parameter="parameter.steering.ratio"]', '1');
  await page.keyboard.press('Enter');
  const hold = (stick, throttle, brake) => page.evaluate(([x, up, down]) => { window.pad = { connected: true, axes: [x, 0, 0, 0], buttons: Array.from({ length: 17 }, (_, k) => ({ value: k === 7 ? up : k === 6 ? down : 0 })) }; }, [stick, throttle, brake]);
  await hold(0.5, 0.625, 0);
  await asked('throttle', 0.625, 0.625);
  await asked('steer', -0.16, -0.02);
  await is('throttle', 0.6, 0.65);
  await hold(0.05, 0, 0.25);
  await asked('throttle', 0, 0);
  await asked('brake', 1e6, 1e6);
  await asked('steer', 0, 0);
  await page.evaluate(() => { window.pad.connected = false; });
  await asked('brake', 0, 0);

  // A finger: up and to the left from where it was put down; a second one does nothing; lifted, all is let go.
  const touch = await page.context().newCDPSession(page), box = await (await page.$(picked)).boundingBox(), [x, y] = [box.x + 0.5 * box.width, box.y + 0.5 * box.height];
  const fingers = (type, ...places) => touch.send('Input.dispatchTouchEvent', { type, touchPoints: places.map(([px, py], id) => ({ x: px, y: py, id })) });
  await fingers('touchStart', [x, y]);
  await fingers('touchMove', [x - 60, y - 90]);
  await asked('throttle', 0.75, 0.75);
  await asked('steer', 0.02, 0.16);
  await fingers('touchStart', [x - 60, y - 90], [x + 100, y + 100]);
  await asked('throttle', 0.75, 0.75);
  await fingers('touchMove', [x, y + 60], [x + 100, y + 100]);
  await asked('brake', 2e6, 2e6);
  await asked('throttle', 0, 0);
  await fingers('touchEnd');
  await asked('brake', 0, 0);
  await page.selectOption('[data-part="live"] [data-role="view"]', 'orbit');
  await page.waitForSelector('[data-view="live"][data-view3d="orbit"]');
  await fingers('touchStart', [x, y]);
  await fingers('touchMove', [x, y - 90]);
  const since = Number(await page.getAttribute('[data-view="live"]', 'data-time'));
  await until((before) => Number(document.querySelector('[data-view="live"]').dataset.time) > before + 0.3, since);
  await asked('throttle', 0, 0);  // round the car it turns the view
  await fingers('touchEnd');

  await page.click('[data-role="end"]');
  await page.waitForSelector('[data-part="live"][data-result="out/drives/car-1.csv"]');
  const driven = readFileSync(join(dir, 'out/drives/car-1.csv'), 'utf8').trim().split('\n').filter((row) => !row.startsWith('#')).map((row) => row.split(','));
  const column = (name) => { const at = driven[0].indexOf(name); return driven.slice(1).map((row) => Number(row[at])); };
  check(column('parameter.chassis.mass_kg').includes(800) && column('parameter.steering.ratio').includes(1) && column('parameter.steering.ratio').includes(2), `what was set is in the table: ${driven[0]}`);
  check(problems.length === 0, problems.join(' | '));
} catch (error) {
  failed(error);
  if (shots) await page?.screenshot({ path: join(shots, 'live-failed.png') });
} finally {
  await browser.close();
  await end(served.server);
  rmSync(dir, { recursive: true });
}
finish();
