// Opens reports in headless Chromium from file:// without a network and uses them.
// usage: node page_test.mjs MAKE_REPORT_PAGES WEB_DIR [SCREENSHOT_DIR]; exit 77: skipped.
// Each report is opened and each feature used once. KERBSTONE_HEAVY=1: in the dark and on phones, every link, colour, file and wrong word.
import { spawnSync } from 'node:child_process';
import { createRequire } from 'node:module';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromiumPath, launch } from '../view/browser.mjs';

/// Machines that build beside it are slow; nothing here waits for long on a calm one.
const kPatience_ms = 180000;

const isHeavy = Boolean(process.env.KERBSTONE_HEAVY);
const [maker, web, shots] = process.argv.slice(2);
if (!chromiumPath || !existsSync(join(web, 'node_modules/playwright-core'))) {
  console.log('skipped: needs chromium and the npm packages of lib/report/web (scripts/setup)');
  process.exit(77);
}
const require = createRequire(resolve(web, 'package.json'));

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

const browser = await launch(require);

async function open(name, options = {}) {
  // A quarter of the pixels of a desk: the processor draws them here. Phones have all of theirs.
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, deviceScaleFactor: shots ? 1 : 0.5, offline: true, ...options });
  context.setDefaultTimeout(kPatience_ms);
  // What stands on canvases, as it was drawn last.
  await context.addInitScript(() => {
    const texts = new WeakMap(), { fillText, clearRect } = CanvasRenderingContext2D.prototype;
    window.drawnTexts = (canvas) => texts.get(canvas) ?? [];
    CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
      if (!texts.has(this.canvas)) texts.set(this.canvas, []);
      texts.get(this.canvas).push([String(text), this.textAlign]);
      return fillText.call(this, text, ...rest);
    };
    CanvasRenderingContext2D.prototype.clearRect = function (...all) {
      texts.set(this.canvas, []);
      return clearRect.apply(this, all);
    };
  });
  const page = await context.newPage();
  const problems = [];
  // The emulated graphics card says that reading its pictures is slow.
  page.on('console', (message) => { if (['error', 'warning'].includes(message.type()) && !/GL Driver Message .*GPU stall due to ReadPixels/.test(message.text())) problems.push(message.text()); });
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
const drawnTexts = (page, selector) => page.$eval(selector, (canvas) => window.drawnTexts(canvas).filter(([text]) => text !== ''));
/// What a click on a button saves.
async function saved(page, button) {
  await page.waitForTimeout(200);  // Chromium drops, without a word, what is saved faster than some ten files a second
  const [download] = await Promise.all([page.waitForEvent('download'), typeof button === 'string' ? page.click(button) : button.click()]);
  const bytes = readFileSync(await download.path());
  return { name: download.suggestedFilename(), bytes, text: bytes.toString('utf8') };
}
/// A picture that a hundredth of a pixel does not change.
const coarse = (page, selector) => page.$eval(selector, (canvas) => {
  const copy = document.createElement('canvas');
  copy.width = 48;
  copy.height = 24;
  const context = copy.getContext('2d');
  context.imageSmoothingQuality = 'high';
  context.drawImage(canvas, 0, 0, 48, 24);
  return [...context.getImageData(0, 0, 48, 24).data];
});
const picture = (page, selector) => page.$eval(selector, (canvas) => canvas.toDataURL());

/// What every report shows, just opened.
async function checkWhole(name, page) {
  check(statSync(join(dir, name, 'report.html')).size < 3e6, `${name}: the page is under 3 MB`);
  for (const view of ['verdict', 'findings', 'plan', 'scene', 'curve-elevation_m', 'curve-slope', 'curve-vertical_curvature_1pm', 'curve-banking', 'curve-banking_deg', 'curve-heading_rad', 'curve-curvature_1pm', 'curve-curvature_rate_1pm2', 'curve-width_m', 'seam',
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
  check(await page.$eval('#report', (node) => [...node.childNodes].every((child) => child.nodeType === 1)), `${name}: no stray text between the panels`);
  if (await page.$('[data-view="lead"]') === null) {
    const rules = await page.$eval('[data-view="rules"]', (node) => node.getBoundingClientRect().bottom + scrollY);
    check(rules <= 900, `${name}: map, verdict and all rules are on the first screen (${rules.toFixed(0)} px)`);
  }
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  check(wide <= 0, `${name}: nothing sticks out to the right (${wide} px)`);
}

/// Printed.
async function checkPrinted(page) {
  // What the browser does at the start of printing: every chart has to fit the paper then.
  await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
  await settle(page);
  const widest = await page.$$eval('.chart canvas', (nodes) => Math.max(...nodes.map((node) => node.getBoundingClientRect().right)));
  check(widest <= 182 / 25.4 * 96 + 1, `print: charts end within the paper (${widest.toFixed(0)} px)`);
  await page.evaluate(() => dispatchEvent(new Event('afterprint')));
  await settle(page);
  const pdf = await page.pdf({ path: shots ? join(shots, 'defects.pdf') : undefined, preferCSSPageSize: true, printBackground: true });
  const sheets = pdf.toString('latin1').match(/\/Type\s*\/Page[^s]/g)?.length;
  check(pdf.length > 50_000 && sheets <= 4, `the page prints on at most four sheets (${sheets}, ${pdf.length} bytes)`);
}

try {
  {
    const { page, context, problems } = await open('clean');
    await checkWhole('clean', page);
    check((await page.innerText('[data-view="verdict"]')).startsWith('Usable'), 'the clean road is usable');
    check(await page.$eval('#verdict', (node) => node.classList.contains('usable')), 'the clean verdict is green');
    // A clean verdict says no more than what was looked for, and the numbers are those of report.json.
    const numbers = JSON.parse(readFileSync(join(dir, 'clean', 'report.json'), 'utf8')), told = await page.innerText('main');
    check(!told.includes('vehicle would notice'), 'nothing is said of what a vehicle would notice');
    check(numbers.looked_for.length >= 3 && numbers.looked_for.every((sentence) => told.includes(sentence)), `what was looked for and the limits are shown (${numbers.looked_for})`);
    check(numbers.facts.length >= 5 && numbers.facts.every((fact) => told.includes(fact.name) && told.includes(fact.value)), 'the facts are those of report.json');
    check((await page.$$('[data-view="kerbs"] .scroll tbody tr')).length === numbers.kerbs.length, 'as many kerbs as in report.json');
    if (shots) {
      await page.screenshot({ path: join(shots, 'clean-light.png') });
      await page.screenshot({ path: join(shots, 'clean-light-full.png'), fullPage: true });
    }
    await context.close();
    check(problems.length === 0, `clean: no console message: ${problems.join(' | ')}`);
  }

  {
    const { page, context, problems } = await open('defects');
    await checkWhole('defects', page);
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
    if (isHeavy) {
      const framed = await picture(page, '[data-view="plan"] canvas');
      await page.click('[data-view="rough"] button.place >> nth=0');
      await settle(page);
      check(await picture(page, '[data-view="plan"] canvas') !== framed, 'its link moves the plan');
      await page.click('[data-role="reset"]');
      await settle(page);
    }

    // Every link among the findings moves every view. KERBSTONE_HEAVY=1: all of them.
    const all = await page.$$('[data-view="findings"] button.place'), nth = isHeavy ? 1 : Math.ceil(all.length / 2);
    const links = all.filter((_, k) => k % nth === 0);
    check(all.length >= 6, `at least six findings have links (${all.length})`);
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
    for (const field of isHeavy ? fields.slice(1) : ['slope', 'error_mesh']) {
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

  if (isHeavy) for (const [name, options] of [['dark', { colorScheme: 'dark' }], ['phone', { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true }],
    ['phone-dark', { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true, colorScheme: 'dark' }]]) {
    const { page, context, problems } = await open('defects', options);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    check(wide <= 0, `${name}: nothing sticks out to the right (${wide} px)`);
    if (options.colorScheme === 'dark') {
      const background = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
      check(background === 'rgb(20, 24, 28)', `${name}: the page is dark (${background})`);
    }
    check(await painted(page, '[data-view="plan"] canvas') > 0.005, `${name}: the plan is drawn`);
    if (shots) {
      await page.screenshot({ path: join(shots, `defects-${name}.png`) });
      await page.screenshot({ path: join(shots, `defects-${name}-full.png`), fullPage: true });
    }
    if (name === 'dark') await checkPrinted(page);
    check(problems.length === 0, `${name}: no console message: ${problems.join(' | ')}`);
    await context.close();
  }

  // What an engineer asks of the page, on a small road whose answers are known (make_report_pages.cpp, crossing()).
  {
    const { page, context, problems } = await open('crossing', { permissions: ['clipboard-read', 'clipboard-write'] });
    // The bridge is the first pass over the middle and yellow; the road below it is dark.
    const middle = await page.$eval('[data-view="plan"] canvas', (canvas) => [...canvas.getContext('2d').getImageData(canvas.width / 2, canvas.height / 2, 1, 1).data]);
    check(middle[0] > 200 && middle[1] > 180 && middle[2] < 90, `the plan shows the bridge over the road that it crosses (${middle})`);

    const text = await page.innerText('main');
    check(!/(^|[^\w])-0(\.0*)?([^\d.]|$)/m.test(text) && !/\d[eE][-+]?\d/.test(text), `no "-0" and no exponent in the text: ${text.match(/.*(-0\s|\de-\d).*/)?.[0]}`);
    for (const view of ['histogram-mesh', 'curve-slope', 'worst-mesh-1', 'heat-mesh', 'curve-drift_x_m_1']) {
      const drawn = await drawnTexts(page, `[data-view="${view}"] canvas`);
      check(drawn.length > 4, `${view} has ticks (${drawn.length})`);
      check(drawn.every(([label]) => !/^-0(\.0*)?$/.test(label)), `${view}: no tick "-0": ${drawn.map(([label]) => label).join(' ')}`);
      check(new Set(drawn.map(String)).size === drawn.length, `${view}: no two ticks alike: ${drawn.map(([label]) => label).join(' ')}`);
      check(drawn.every(([label]) => !/^-?\d/.test(label) || (label.length <= 9 && !label.includes('e'))), `${view}: no tick with meaningless digits: ${drawn.map(([label]) => label).join(' ')}`);
    }

    // Typing a place.
    const shown = async () => (await rangesOf(page)).find(([view]) => view === 'heat-mesh').slice(1);
    const heatLegend = () => page.innerText('[data-role="above"]');
    const limitOfAll = await heatLegend();
    await page.fill('[data-role="go-to"]', '302.5');
    await page.press('[data-role="go-to"]', 'Enter');
    await settle(page);
    for (const [view, low, high] of await rangesOf(page)) check(low < 302.5 && high > 302.5 && high - low < 60, `${view} goes to a typed u (${low} to ${high})`);
    const limitHere = await heatLegend();
    check(limitOfAll === '0.015 mm above' && limitHere === '30 mm above', `the error map's scale follows the zoom (${limitOfAll}, then ${limitHere})`);
    const before = await shown();
    for (const wrong of isHeavy ? ['601', 'abc', '', '<b>', '5e1', '20 to 10'] : ['601', '<b>']) {
      await page.fill('[data-role="go-to"]', wrong);
      await page.press('[data-role="go-to"]', 'Enter');
      await settle(page);
      check(String(await shown()) === String(before), `"${wrong}" leads nowhere`);
      check(await page.getAttribute('[data-role="go-to"]', 'aria-invalid') === 'true', `"${wrong}" is marked as wrong`);
    }
    await page.fill('[data-role="go-to"]', '100 to 200');
    await page.press('[data-role="go-to"]', 'Enter');
    await settle(page);
    check(String(await shown()) === '50,250', `a typed stretch is shown with room around it (${await shown()})`);

    // Keys: nearer, along, whole; on a chart, on the plan, in space, and where nothing has the keyboard.
    for (const view of isHeavy ? ['curve-elevation_m', 'heat-mesh'] : ['curve-elevation_m']) {
      await page.focus(`[data-view="${view}"]`);
      await page.keyboard.press('0');
      check(String(await shown()) === '0,600', `${view}: 0 shows the whole road (${await shown()})`);
      await page.keyboard.press('+');
      const [low, high] = await shown();
      check(high - low < 450, `${view}: + zooms (${low} to ${high})`);
      await page.keyboard.press('ArrowRight');
      const [low2, high2] = await shown();
      check(low2 > low && Math.abs(high2 - low2 - high + low) < 1, `${view}: an arrow moves along (${low2} to ${high2})`);
      await page.keyboard.press('-');
      const [low3, high3] = await shown();
      check(high3 - low3 > high2 - low2 + 1, `${view}: - zooms out`);
    }
    // From so far that all columns are one pixel.
    await page.focus('[data-view="plan"] canvas');
    for (let k = 0; k < 12; ++k) await page.keyboard.press('-');
    await settle(page);
    check(await painted(page, '[data-view="plan"] canvas') > 1e-4, 'a road that is narrower than a pixel is drawn');
    for (const view of ['plan', 'scene']) {
      const canvas = `[data-view="${view}"] canvas`;
      await page.focus(canvas);
      await page.keyboard.press('0');
      await settle(page);
      let last = await picture(page, canvas);
      for (const key of ['+', 'ArrowUp', 'ArrowLeft', '-']) {
        await page.keyboard.press(key);
        await settle(page);
        const now = await picture(page, canvas);
        check(now !== last, `${view}: the key ${key} moves it`);
        last = now;
      }
    }
    await page.evaluate(() => { document.activeElement.blur(); scrollTo(0, 0); });
    await page.keyboard.press('0');
    await page.keyboard.press('+');
    check((await shown())[1] - (await shown())[0] < 450, 'keys work where nothing has the keyboard');
    check(!await page.isVisible('[data-role="keys"]'), 'the help is not in the way');
    await page.keyboard.press('?');
    check((await page.innerText('[data-role="keys"]')).includes('whole road'), '? says what the keys do');
    await page.keyboard.press('Escape');
    check(!await page.isVisible('[data-role="keys"]'), 'Escape closes the help');
    // A chart of its own zooms by itself.
    const ticks = String(await drawnTexts(page, '[data-view="histogram-mesh"] canvas'));
    await page.focus('[data-view="histogram-mesh"]');
    await page.keyboard.press('+');
    await settle(page);
    check(String(await drawnTexts(page, '[data-view="histogram-mesh"] canvas')) !== ticks, 'the histogram zooms by keys');
    await page.keyboard.press('0');
    await settle(page);
    check(String(await drawnTexts(page, '[data-view="histogram-mesh"] canvas')) === ticks, 'and 0 shows all of it again');
    await page.click('[data-role="reset"]');
    await settle(page);

    // A wheel scrolls the page, unless the plot was clicked.
    await page.$eval('[data-view="plan"]', (node) => node.scrollIntoView({ block: 'center' }));
    const box = await (await page.$('[data-view="plan"] canvas')).boundingBox();
    await page.evaluate(() => document.activeElement.blur());
    await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
    const scrolled = await page.evaluate(() => scrollY);
    await page.mouse.wheel(0, 120);
    await page.waitForFunction((y) => scrollY !== y, scrolled, { timeout: 10000 }).catch(() => check(false, 'a wheel over the plan scrolls the page'));
    await page.mouse.wheel(0, -120);
    await page.waitForFunction((y) => Math.abs(scrollY - y) < 2, scrolled, { timeout: 10000 }).catch(() => {});

    // A cross section anywhere: on top of the bridge by a click, elsewhere by typing.
    await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
    await settle(page);
    const clicked = await page.innerText('[data-role="cut-text"]');
    const [, u, v, z] = clicked.match(/u ([-\d.]+) m, v ([-\d.]+) m: z ([-\d.]+) m/) ?? [];
    check(Math.abs(u - 150) < 1.5 && Math.abs(v) < 1.5 && Math.abs(z - 8) < 0.01, `a click on the plan cuts the bridge, not the road below (${clicked})`);
    const zoomBefore = await picture(page, '[data-view="plan"] canvas');
    await page.mouse.wheel(0, -240);
    await settle(page);
    check(await picture(page, '[data-view="plan"] canvas') !== zoomBefore, 'a wheel over the clicked plan zooms');
    await page.click('[data-role="reset"]');
    await page.fill('[data-role="cut-u"]', '450,25');
    await page.fill('[data-role="cut-v"]', '2.5');
    await page.press('[data-role="cut-v"]', 'Enter');
    await settle(page);
    const cut = await page.innerText('[data-role="cut-text"]');
    check(cut.includes('u 450.25 m, v 2.50 m: z 0.030 m'), `the cut has the height at the typed place (${cut})`);
    check(await painted(page, '[data-view="cut-plot"] canvas') > 0.005, 'the cut is drawn');
    const ofCut = await saved(page, '[data-view="cut-plot"] [data-save="csv"]');
    check(ofCut.name === 'Crossing-cut-plot.csv' && ofCut.text.startsWith('u / m,v / m,z / m\r\n450,-5,0\r\n') && ofCut.text.includes('\r\n450,2.5,0.03\r\n'), `its numbers are those of the file (${ofCut.name}: ${ofCut.text.slice(0, 200)})`);
    await page.fill('[data-role="cut-v"]', '7');
    await page.press('[data-role="cut-v"]', 'Enter');
    check(await page.getAttribute('[data-role="cut-v"]', 'aria-invalid') === 'true' && await page.innerText('[data-role="cut-text"]') === cut, 'a v beside the road is refused');

    // From point to point, by two clicks and by typing.
    await page.click('[data-role="measuring"]');
    await page.$eval('[data-view="plan"]', (node) => node.scrollIntoView({ block: 'center' }));
    const again = await (await page.$('[data-view="plan"] canvas')).boundingBox();
    for (const x of [0.5, 0.502]) await page.mouse.click(again.x + x * again.width, again.y + 0.5 * again.height);
    await settle(page);
    const twice = await page.innerText('[data-role="measured"]');
    check(/Plan distance\s+[1-9]?\d\.\d{3} m/.test(twice), `two clicks measure (${twice})`);
    await page.click('[data-role="measuring"]');
    for (const [role, value] of [['first-u', '150'], ['first-v', '0'], ['second-u', '450'], ['second-v', '3']]) await page.fill(`[data-role="${role}"]`, value);
    await page.press('[data-role="second-v"]', 'Enter');
    const measured = (await page.innerText('[data-role="measured"]')).replace(/\s+/g, ' ');
    check(measured.includes('Plan distance 3.000 m') && measured.includes('Height difference -8.000 m') && measured.includes('du 300.00 m') && measured.includes('dv 3.00 m') && measured.includes('space 8.544 m'),
      `plan distance, height difference, du and dv (${measured})`);

    // A link leads to all of it, also to a plan that was moved by hand.
    await page.selectOption('[data-role="field"]', 'grip');
    await page.fill('[data-role="go-to"]', '200');
    await page.press('[data-role="go-to"]', 'Enter');
    await page.focus('[data-view="plan"] canvas');
    await page.keyboard.press('ArrowRight');
    await page.waitForTimeout(600);
    await settle(page);
    await page.click('[data-role="link"]');
    await page.waitForFunction(() => document.querySelector('[data-role="link"]').textContent !== 'Copy link', null, { timeout: 10000 });
    const link = await page.evaluate(() => navigator.clipboard.readText());
    check(link.includes('cut=450.25,2.5') && link.includes('measure=150,0,450,3') && link === page.url(), `the link says where, as the address does (${link}; ${page.url()})`);
    const there = await context.newPage();
    there.on('pageerror', (error) => problems.push(String(error)));
    await there.goto(link);
    await there.waitForSelector('html[data-ready="yes"]');
    await settle(there);
    check(String(await rangesOf(there)) === String(await rangesOf(page)), `a link restores what every view shows (${await rangesOf(there)}; ${await rangesOf(page)})`);
    for (const role of ['cut-text', 'measured']) check(await there.innerText(`[data-role="${role}"]`) === await page.innerText(`[data-role="${role}"]`), `a link restores ${role}`);
    check(await there.inputValue('[data-role="field"]') === 'grip', 'a link restores the colour');
    check(await there.evaluate(() => scrollY) > 0, 'a link scrolls to the map');
    await page.evaluate(() => document.activeElement.blur());
    await page.mouse.move(2, 2);
    const [here, restored] = [await coarse(page, '[data-view="plan"] canvas'), await coarse(there, '[data-view="plan"] canvas')];
    check(Math.max(...here.map((value, k) => Math.abs(value - restored[k]))) < 12, 'a link restores the plan');
    // Links come from strangers too.
    const strange = ['#u=NaN,1e999&colour=%3Cimg%20src=x%3E&cut=1,2,3&measure=<script>&plan=0,0,0', '#u=-5,1e3&place=__proto__', '#place=99999,99999', '#__proto__=1&cut=99999,0', '#track'];
    for (const hash of isHeavy ? strange : strange.slice(0, 1)) {
      await there.goto('about:blank');
      await there.goto(link.replace(/#.*/, hash));
      await there.waitForSelector('html[data-ready="yes"]');
      check((await rangesOf(there)).every(([, low, high]) => low === 0 && high === 600), `${hash} shows the whole road`);
      check((await there.innerText('[data-role="cut-text"]')).startsWith('Click'), `${hash} cuts nothing`);
    }
    await there.close();

    // Every plot and its numbers as files.
    await page.click('[data-role="reset"]');
    await settle(page);
    const every = async (ending) => await page.$$(`[data-save="${ending}"]`), of = async (ending, ...views) => await page.$$(views.map((view) => `[data-view="${view}"] [data-save="${ending}"]`).join());
    const count = (await every('png')).length;
    check(count >= 9 && (await every('csv')).length === count, `every plot can be saved (${count})`);
    const pictures = isHeavy ? await every('png') : await of('png', 'plan', 'scene', 'curve-elevation_m');
    const tables = isHeavy ? await every('csv') : await of('csv', 'curve-elevation_m', 'heat-mesh', 'curve-drift_x_m_1', 'extra');
    check(isHeavy || (pictures.length === 3 && tables.length === 4), `some of them are (${pictures.length}, ${tables.length})`);
    const names = new Set();
    for (const button of pictures) {
      const { name, bytes } = await saved(page, button);
      names.add(name);
      check(bytes.length > 500 && bytes.readUInt32BE(0) === 0x89504e47 && bytes.readUInt32BE(16) >= 100, `${name} is a picture (${bytes.length} bytes)`);
    }
    for (const button of tables) {
      const { name, text: table } = await saved(page, button);
      names.add(name);
      const lines = table.trim().split('\r\n');
      check(lines.length > 1 && /^[A-Za-z'"]/.test(lines[0]) && lines.slice(1).every((row) => /^-?[\d.]+(e-\d+)?,/.test(row)), `${name} is a table (${lines.slice(0, 3).join(' | ')})`);
      check(!/(^|,)"?\s*[=@+]/m.test(table), `${name} has no formula`);
      if (name.includes('elevation')) check(lines.length === 602 && Math.abs(lines[151].split(',')[1] - 8) < 1e-4, `${name} has every row (${lines.length}, ${lines[151]})`);
      if (name.includes('heat')) check(lines.includes('302.5,0,20,0'), `${name} has the errors`);
      if (name.includes('drift')) check(lines[0] === '"u / m","\'=Drift / mm"' || lines[0] === 'u / m,"\'=Drift / mm"', `${name} keeps a formula as text (${lines[0]})`);
      if (name.includes('extra')) check(lines[0] === 'v / m,"\'=1+1: z / m","say ""hi"", you: z / m","\'\t@x: z / m"' && lines[1] === '-1,0.5,-0.5,1', `${name} quotes what it has to (${lines[0]})`);
    }
    check(names.size === pictures.length + tables.length, 'no two files have one name');
    check([...names].every((name) => /^Crossing-[\w.-]+\.(png|csv)$/.test(name)), `names of files are plain (${[...names].join(' ')})`);
    if (!isHeavy) await checkPrinted(page);  // else one of many more charts, in the dark
    check(problems.length === 0, `crossing: no console message: ${problems.join(' | ')}`);
    if (shots) await page.screenshot({ path: join(shots, 'crossing-full.png'), fullPage: true });
    await context.close();
  }

  {
    // One finger scrolls the page wherever it lands; two fingers belong to the plot.
    const { page, context, problems } = await open('crossing', { viewport: { width: 390, height: 844 }, deviceScaleFactor: isHeavy ? 2 : 1, isMobile: true, hasTouch: true });
    const devtools = await context.newCDPSession(page);
    const touch = (type, points) => devtools.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const gesture = async (from, to) => {
      await touch('touchStart', from);
      for (let k = 1; k <= 8; ++k) {
        await touch('touchMove', from.map(([x, y], i) => [x + (to[i][0] - x) * k / 8, y + (to[i][1] - y) * k / 8]));
        await settle(page);
      }
      // Held still, so that the page does not roll on.
      await page.waitForTimeout(150);
      await touch('touchMove', to);
      await touch('touchEnd', []);
      await page.waitForFunction(() => new Promise((done) => { const y = scrollY; setTimeout(() => done(scrollY === y), 120); }));
    };
    const targets = [['plan', '[data-view="plan"] canvas'], ['scene', '[data-view="scene"] canvas'], ['curve-elevation_m', '[data-view="curve-elevation_m"] .u-over'],
      ['heat-mesh', '[data-view="heat-mesh"] .u-over'], ['histogram-mesh', '[data-view="histogram-mesh"] .u-over']];
    for (const [view, target] of isHeavy ? targets : targets.slice(0, 2)) {
      const canvas = `[data-view="${view}"] canvas`;
      await page.$eval(target, (node) => node.scrollIntoView({ block: 'center' }));
      await settle(page);
      const area = await (await page.$(target)).boundingBox();
      const [x, y] = [area.x + 0.5 * area.width, area.y + 0.5 * area.height];
      const from = await page.evaluate(() => scrollY), still = await picture(page, canvas);
      await gesture([[x - 40, y], [x + 40, y]], [[x - 110, y], [x + 110, y]]);
      await page.waitForTimeout(50);
      check(await picture(page, canvas) !== still, `two fingers zoom ${view}`);
      const [top, scale] = await page.$eval(target, (node) => [node.getBoundingClientRect().top, visualViewport.scale]);
      check(Math.abs(top - area.y) < 2 && scale === 1, `two fingers on ${view} leave the page where it is (${area.y}; ${top}, ${scale})`);
      const zoomed = view === 'scene' ? await picture(page, canvas) : null;
      await gesture([[x, y + 60]], [[x, y - 90]]);
      await page.waitForFunction((old) => scrollY > old + 40, from, { timeout: 5000 }).catch(() => check(false, `one finger on ${view} scrolls the page`));
      if (zoomed) check(await picture(page, canvas) === zoomed, `one finger does not turn ${view}`);
    }
    // A tap cuts.
    await page.click('[data-role="reset"]');
    await page.$eval('[data-view="plan"]', (node) => node.scrollIntoView({ block: 'center' }));
    await settle(page);
    const area = await (await page.$('[data-view="plan"] canvas')).boundingBox();
    await page.touchscreen.tap(area.x + 0.5 * area.width, area.y + 0.5 * area.height);
    await settle(page);
    check(/z (8\.000|7\.99\d) m/.test(await page.innerText('[data-role="cut-text"]')), `a tap on the plan cuts (${await page.innerText('[data-role="cut-text"]')})`);
    check(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth) <= 0, 'crossing on a phone: nothing sticks out to the right');
    check(problems.length === 0, `crossing on a phone: no console message: ${problems.join(' | ')}`);
    if (shots) await page.screenshot({ path: join(shots, 'crossing-phone.png') });
    await context.close();
  }
} finally {
  await browser.close();
  rmSync(dir, { recursive: true, force: true });
}
console.log(failures === 0 ? 'all checks of the page hold' : `${failures} checks failed`);
process.exit(failures === 0 ? 0 : 1);
