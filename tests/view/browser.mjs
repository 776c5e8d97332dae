// kerbstone view served on a folder, and a headless Chromium that opens it: for the tests of the page.
import { spawn, spawnSync } from 'node:child_process';
import { createRequire } from 'node:module';
import { existsSync, readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';

/// Machines that build beside it are slow; nothing here waits for long on a calm one.
export const kPatience_ms = 120000;

/// Whether all is done; else each part of the page is opened and each feature used once.
export const isHeavy = Boolean(process.env.KERBSTONE_HEAVY);

/// The demo circuit, or a smaller one.
export const circuitOf = (source) => join(source, isHeavy ? 'tracks/kerbstone-ring/circuit.yaml' : 'tests/view/oval.yaml');

export const chromiumPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);

/// Ends the test as skipped where something is missing; gives require() of the npm packages.
export function packagesOf(source) {
  const web = join(source, 'lib/report/web');
  if (!chromiumPath || !existsSync(join(web, 'node_modules/axe-core'))) {
    console.log('skipped: needs chromium and the npm packages of lib/report/web (scripts/setup)');
    process.exit(77);
  }
  return createRequire(resolve(web, 'package.json'));
}

/// Resolves to {server, address}. `before`: words in front of the command.
export async function serve(kerbstone, folder, words = [], before = []) {
  const [program, ...rest] = [...before, kerbstone, 'view', folder, '--no-open', ...words];
  const server = spawn(program, rest, { stdio: ['ignore', 'pipe', 'inherit'] });
  const address = await new Promise((done, lost) => {
    let text = '';
    server.stdout.on('data', (bytes) => { text += bytes; if (text.includes('\n')) done(text.trim()); });
    server.on('exit', () => lost(new Error('kerbstone view ended')));
  });
  return { server, address };
}

/// Ends the program that serves; resolves when it has.
export function end(server) {
  const ended = new Promise((done) => { server.on('exit', done); });
  server.kill('SIGTERM');
  return ended;
}

// Chromium draws the list below its address line beforehand, for each window, which costs as much as a small page. Of this switch the last one counts: the others are those of playwright.
const without = ['WebUIOmniboxPopup', 'WebUIOmniboxAimPopup', 'AvoidUnnecessaryBeforeUnloadCheckSync', 'BoundaryEventDispatchTracksNodeRemoval', 'DestroyProfileOnBrowserClose',
  'DialMediaRouteProvider', 'GlobalMediaControls', 'HttpsUpgrades', 'LensOverlay', 'MediaRouter', 'OptimizationHints', 'PaintHolding', 'RenderDocument', 'ThirdPartyStoragePartitioning', 'Translate'];

/// A browser in which the processor draws.
export const launch = (require, words = []) => require('playwright-core').chromium.launch({
  executablePath: chromiumPath, headless: true,
  // The scene alone is drawn by an emulated graphics card; all else without one, the page composed of its parts, too: half the work.
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
    '--disable-gpu-rasterization', '--disable-gpu-compositing', '--disable-accelerated-2d-canvas', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--no-first-run', `--disable-features=${without.join()}`, ...words],
});

/// A page of that browser, not loaded yet, and what tests do with it. `shots`: the folder of pictures, if wanted. `more`: of the context.
export async function opened(browser, require, shots, more = {}) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, deviceScaleFactor: shots ? 1 : 0.5, ...more });
  context.setDefaultTimeout(kPatience_ms);
  const page = await context.newPage(), problems = [], axe = readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');
  page.on('pageerror', (error) => problems.push(String(error.stack)));
  return {
    context, page, problems,
    picture: async (name) => { if (shots) await page.screenshot({ path: join(shots, `${name}.png`) }); },
    until: (test, argument) => page.waitForFunction(test, argument, { timeout: kPatience_ms }),
    async accessible(part) {
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => window.axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'], iframes: false }));
      for (const each of violations) check(false, `${part}: ${each.id}: ${each.help}: ${each.nodes.map((node) => node.html).slice(0, 3).join(' | ')}`);
    },
  };
}

let failures = 0;

/// Counts what does not hold, and says it.
export function check(condition, text) {
  if (condition) return;
  ++failures;
  console.error(`FAILED: ${text}`);
}

/// Counts what was thrown.
export function failed(error) {
  ++failures;
  console.error(error);
}

/// Runs a program to its end; throws with what it said where that is not well. 3: done, and not to be used.
export function run(program, words, cwd, good = [0]) {
  const ran = spawnSync(program, words, { cwd, encoding: 'utf8', maxBuffer: 1e9 });
  if (!good.includes(ran.status)) throw new Error(`${program} ${words.join(' ')}: ${ran.error ?? ran.stderr}`);
  return ran;
}

/// Says how it went, and ends the test.
export function finish() {
  console.log(failures === 0 ? 'passed' : `${failures} failures`);
  process.exit(failures === 0 ? 0 : 1);
}
export const allIsWell = () => failures === 0;
