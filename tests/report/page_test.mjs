// Opens reports in headless Chromium from file:// without a network and uses them.
// usage: node page_test.mjs MAKE_REPORT_PAGES WEB_DIR [SCREENSHOT_DIR]; exit 77: skipped.
import { spawnSync } from 'node:child_process';
import { createRequire } from 'node:module';
import { existsSync, mkdirSync, mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

/// Machines that build beside it are slow; nothing here waits for long on a calm one.
const kPatience_ms = 180000;

const [maker, web, shots] = process.argv.slice(2);
const chromiumPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
if (!chromiumPath || !existsSync(join(web, 'node_modules/playwright-core'))) {
  console.log('skipped: needs chromium and the npm packages of lib/report/web (scripts/setup)');
  process.exit(77);
}
const { chromium } = createRequire(resolve(web, 'package.json'))('playwright-core');

let failures = 0;
function check(condition, text) {
  if (!condition) {
    ++failures;
    console.error(`FAILED: ${text}`);
  }
}

const dir = mkdtempSync(join(tmpdir(), 'report-pages-'));
const made = spawnSync(maker, [dir], { stdio: 'inherit' });
if (made.status !== 0) process.exit(made.status ?? 1);
if (shots) mkdirSync(shots, { recursive: true });

const browser = await chromium.launch({
  executablePath: chromiumPath, headless: true,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--no-first-run'],
});

async function open(name, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, offline: true, ...options });
  context.setDefaultTimeout(kPatience_ms);
  const page = await context.newPage();
  const problems = [];
  page.on('console', (message) => { if (['error', 'warning'].includes(message.type())) problems.push(message.text()); });
  page.on('pageerror', (error) => problems.push(String(error)));
  page.on('request', (request) => { if (!/^(file|data|blob):/.test(request.url())) problems.push(`request: ${request.url()}`); });
  page.on('dialog', (dialog) => { problems.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  await page.goto(pathToFileURL(join(dir, name, 'report.html')).href);
  await page.waitForSelector('html[data-ready="yes"]', { timeout: kPatience_ms });
  await page.waitForTimeout(300);
  return { page, context, problems };
}

const settle = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30))))));
const rangesOf = (page) => page.$$eval('[data-u-begin]', (nodes) => nodes.map((node) => [node.dataset.view, Number(node.dataset.uBegin), Number(node.dataset.uEnd)]));
/// Share of pixels of a canvas that differ from its first pixel.
const painted = (page, selector) => page.$eval(selector, (canvas) => {
  const copy = document.createElement('canvas');
  copy.width = canvas.width;
  copy.height = canvas.height;
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  let other = 0;
  for (let k = 0; k < data.length; k += 4) other += data[k] !== data[0] || data[k + 1] !== data[1] || data[k + 2] !== data[2];
  return other / (data.length / 4);
});
const picture = (page, selector) => page.$eval(selector, (canvas) => canvas.toDataURL());

try {
  for (const name of ['clean', 'defects']) {
    check(statSync(join(dir, name, 'report.html')).size < 15e6, `${name}: the page is under 15 MB`);
    const { page, context, problems } = await open(name);
    for (const view of ['verdict', 'findings', 'plan', 'scene', 'curve-elevation_m', 'curve-slope', 'curve-banking', 'curve-curvature_1pm', 'curve-width_m', 'seam',
      'errors', 'kerbs', 'roughness', 'psd', 'iri', 'health']) {
      check(await page.$(`[data-view="${view}"]`) !== null, `${name}: view ${view} is present`);
    }
    check(await page.getAttribute('[data-view="scene"]', 'data-webgl') === 'yes', `${name}: the 3-D view has WebGL`);
    check(await painted(page, '[data-view="plan"] canvas') > 0.005, `${name}: the plan is drawn`);
    check(await painted(page, '[data-view="scene"] canvas') > 0.005, `${name}: the 3-D view is drawn`);
    for (const selector of ['[data-view="curve-elevation_m"] canvas', '[data-view="psd"] canvas', '[data-view="iri"] canvas']) {
      check(await painted(page, selector) > 0.005, `${name}: ${selector} is drawn`);
    }
    // The word NaN may stand in a finding of the file check, never as a number.
    check(!/undefined|\[object|NaN ?(mm|m\b|%|\n|$)/.test(await page.innerText('main')), `${name}: no NaN number, undefined or object in the text`);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    check(wide <= 0, `${name}: nothing sticks out to the right (${wide} px)`);
    check(problems.length === 0, `${name}: no console message: ${problems.join(' | ')}`);
    await context.close();
  }

  {
    const { page, context, problems } = await open('clean');
    check((await page.innerText('[data-view="verdict"]')).startsWith('Usable'), 'the clean road is usable');
    check(await page.$eval('#verdict', (node) => node.classList.contains('usable')), 'the clean verdict is green');
    if (shots) {
      await page.screenshot({ path: join(shots, 'clean-light.png') });
      await page.screenshot({ path: join(shots, 'clean-light-full.png'), fullPage: true });
    }
    await context.close();
    check(problems.length === 0, 'clean again: no console message');
  }

  {
    const { page, context, problems } = await open('defects');
    check((await page.innerText('[data-view="verdict"]')).startsWith('Not usable'), 'the road with defects is not usable');
    for (const view of ['rough', 'heat-mesh', 'heat-against', 'heat-before', 'histogram-mesh', 'worst', 'curve-largest_error_mesh_m']) {
      check(await page.$(`[data-view="${view}"]`) !== null, `view ${view} is present`);
    }
    check((await page.$$('[data-view="worst"]')).length === 30, 'ten worst places for each of three comparisons');
    check(await painted(page, '[data-view="heat-mesh"] canvas') > 0.05, 'the heat map is drawn');
    const rough = await page.innerText('[data-view="rough"]');
    check(rough.includes('more than 15 mm') && rough.includes('nodes are off the mesh'), `the stretches that leave the mesh say why: ${rough.slice(0, 200)}`);
    // The bump of 100 mm at u = 120 m is the largest.
    const [roughBegin, roughEnd] = await page.$eval('[data-view="rough"] button.place', (node) => [Number(node.dataset.begin), Number(node.dataset.end)]);
    check(roughBegin > 118.5 && roughEnd < 121.5, `the largest stretch is the bump (${roughBegin} to ${roughEnd})`);
    const framed = await picture(page, '[data-view="plan"] canvas');
    await page.click('[data-view="rough"] button.place >> nth=0');
    await settle(page);
    check(await picture(page, '[data-view="plan"] canvas') !== framed, 'its link moves the plan');
    await page.click('[data-role="reset"]');
    await settle(page);

    // Every link among the findings moves every view.
    const links = await page.$$('[data-view="findings"] button.place');
    check(links.length >= 6, `at least six findings have links (${links.length})`);
    const whole = await rangesOf(page);
    check(whole.length >= 12, `at least twelve views follow u (${whole.length})`);
    let planBefore = await picture(page, '[data-view="plan"] canvas'), sceneBefore = await picture(page, '[data-view="scene"] canvas');
    for (const link of links) {
      const begin = Number(await link.getAttribute('data-begin')), end = Number(await link.getAttribute('data-end'));
      if (end - begin > 400) continue;
      await link.click();
      await settle(page);
      for (const [view, low, high] of await rangesOf(page)) {
        check(low <= begin + 1e-3 && high >= end - 1e-3 && high - low < Math.max(250, 2.5 * (end - begin)), `${view} shows u ${begin} to ${end} after its link (it shows ${low} to ${high})`);
      }
      const plan = await picture(page, '[data-view="plan"] canvas'), scene = await picture(page, '[data-view="scene"] canvas');
      check(plan !== planBefore, `the plan moved to ${begin}`);
      check(scene !== sceneBefore, `the 3-D view moved to ${begin}`);
      planBefore = plan;
      sceneBefore = scene;
    }
    if (shots) {
      await page.click('[data-view="findings"] button.place >> nth=0');
      await settle(page);
      await page.$eval('#track', (node) => node.scrollIntoView());
      await settle(page);
      await page.screenshot({ path: join(shots, 'defects-place.png') });
    }
    // Back to the whole road.
    await page.click('[data-role="reset"]');
    await settle(page);
    for (const [view, low, high] of await rangesOf(page)) check(high - low > 900, `${view} shows the whole road again (${low} to ${high})`);

    // Dragging across one curve zooms all views; hovering moves the cursor of all.
    await page.$eval('[data-view="curve-slope"]', (node) => node.scrollIntoView({ block: 'center' }));
    const over = await page.$('[data-view="curve-slope"] .u-over');
    const box = await over.boundingBox();
    await page.mouse.move(box.x + 0.3 * box.width, box.y + 40);
    await page.mouse.down();
    await page.mouse.move(box.x + 0.5 * box.width, box.y + 40, { steps: 5 });
    await page.mouse.up();
    await settle(page);
    for (const [view, low, high] of await rangesOf(page)) {
      check(high - low > 100 && high - low < 300 && low > 200 && high < 600, `${view} follows a zoom by dragging (${low} to ${high})`);
    }
    const planStill = await picture(page, '[data-view="plan"] canvas');
    await page.mouse.move(box.x + 0.8 * box.width, box.y + 60);
    await settle(page);
    check(await picture(page, '[data-view="plan"] canvas') !== planStill, 'the cursor of a curve shows on the plan');
    const lefts = await page.$$eval('[data-view^="curve-"] .u-cursor-x', (nodes) => nodes.map((node) => node.style.transform));
    check(new Set(lefts).size === 1, `the cursors of all curves stand at the same u (${[...new Set(lefts)].join(' ')})`);

    // Colours.
    const fields = await page.$$eval('[data-role="field"] option', (nodes) => nodes.map((node) => node.value));
    for (const field of ['elevation', 'slope', 'banking', 'curvature', 'error_mesh', 'error_against', 'error_before']) check(fields.includes(field), `colour ${field} can be chosen`);
    let last = await picture(page, '[data-view="plan"] canvas');
    for (const field of fields.slice(1)) {
      await page.selectOption('[data-role="field"]', field);
      await settle(page);
      const now = await picture(page, '[data-view="plan"] canvas');
      check(now !== last, `colour ${field} changes the plan`);
      last = now;
    }

    // Markup in names stays text.
    check(await page.evaluate(() => window.hacked) === undefined, 'no script of a name ran');
    check(await page.$('main img:not(.scene > img), main script') === null, 'no element came out of a name');
    const text = await page.textContent('main');
    check(text.includes('<img src=x onerror="window.hacked=1"></script>'), 'the name with markup is shown as it is');
    check(problems.length === 0, `defects: no console message: ${problems.join(' | ')}`);
    if (shots) {
      await page.click('[data-role="reset"]');
      await settle(page);
      await page.screenshot({ path: join(shots, 'defects-light-full.png'), fullPage: true });
    }
    await context.close();
  }

  for (const [name, options] of [['dark', { colorScheme: 'dark' }], ['phone', { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true }],
    ['phone-dark', { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true, colorScheme: 'dark' }]]) {
    const { page, context, problems } = await open('defects', options);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    check(wide <= 0, `${name}: nothing sticks out to the right (${wide} px)`);
    if (options.colorScheme === 'dark') {
      const background = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
      check(background === 'rgb(20, 24, 28)', `${name}: the page is dark (${background})`);
    }
    check(await painted(page, '[data-view="plan"] canvas') > 0.005, `${name}: the plan is drawn`);
    check(problems.length === 0, `${name}: no console message: ${problems.join(' | ')}`);
    if (shots) {
      await page.screenshot({ path: join(shots, `defects-${name}.png`) });
      await page.screenshot({ path: join(shots, `defects-${name}-full.png`), fullPage: true });
    }
    await context.close();
  }

  {
    // Printed from a dark page.
    const { page, context, problems } = await open('defects', { colorScheme: 'dark' });
    // What the browser does at the start of printing: every chart has to fit the paper then.
    await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
    await settle(page);
    const widest = await page.$$eval('.chart canvas', (nodes) => Math.max(...nodes.map((node) => node.getBoundingClientRect().right)));
    check(widest <= 182 / 25.4 * 96 + 1, `print: charts end within the paper (${widest.toFixed(0)} px)`);
    await page.evaluate(() => dispatchEvent(new Event('afterprint')));
    await settle(page);
    const pdf = await page.pdf({ path: shots ? join(shots, 'defects.pdf') : undefined, preferCSSPageSize: true, printBackground: true });
    check(pdf.length > 50_000, `the page prints (${pdf.length} bytes)`);
    check(problems.length === 0, `print: no console message: ${problems.join(' | ')}`);
    await context.close();
  }
} finally {
  await browser.close();
  rmSync(dir, { recursive: true, force: true });
}
console.log(failures === 0 ? 'all checks of the page hold' : `${failures} checks failed`);
process.exit(failures === 0 ? 0 : 1);
