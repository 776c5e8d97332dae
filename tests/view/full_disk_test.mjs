// A disk that is full while a whole build runs, with a browser: said on the page, nothing that was there is lost, and it goes on when there is room again.
// usage: node full_disk_test.mjs KERBSTONE CRGBUILD SOURCE; exit 77: skipped.
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, statfsSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { check, end, failed, finish, kPatience_ms, launch, packagesOf, run, serve } from './browser.mjs';

const [kerbstone, crgbuild, source] = process.argv.slice(2);
const require = packagesOf(source);


const dir = mkdtempSync(join(tmpdir(), 'kerbstone-full-disk-')), disk = join(dir, 'disk');
mkdirSync(disk);
// 48 MB hold the mesh and two builds of it: files of a new one lie beside those of the old one until they take their place.
if (spawnSync('mount', ['-t', 'tmpfs', '-o', 'size=48m', 'tmpfs', disk]).status !== 0) {
  console.log('skipped: no small disk can be mounted here (needs root); view_page has the same with a bound on the size of files');
  rmSync(dir, { recursive: true });
  process.exit(77);
}

let served, browser;
try {
  run(crgbuild, ['synth', join(source, 'tracks/kerbstone-ring/circuit.yaml'), '-o', join(dir, 'made'), '--step-m', '4', '-q']);
  mkdirSync(join(disk, 'ring'));
  for (const name of readdirSync(join(dir, 'made'))) if (/\.(obj|mtl)$/.test(name)) cpSync(join(dir, 'made', name), join(disk, 'ring', name));
  writeFileSync(join(disk, 'ring/track.yaml'), 'mesh: kerbstone-ring.obj\nname: ring\nu_step_m: 0.5\nv_step_m: 0.5\n');
  served = await serve(kerbstone, disk);
  browser = await launch(require);
  const page = await (await browser.newContext({ viewport: { width: 1400, height: 900 }, deviceScaleFactor: 0.5 })).newPage();
  page.setDefaultTimeout(kPatience_ms);
  const said = (word) => page.waitForFunction((text) => document.querySelector('[data-part="track"] [data-role="note"]')?.textContent.includes(text), word, { timeout: kPatience_ms });
  await page.goto(served.address);
  await page.waitForSelector('html[data-ready="yes"]');
  await page.click('[data-id="0/ring/track.yaml"]');
  await page.waitForSelector('.stage[data-parts]');
  await page.click('[data-role="build"]');
  await said('Built.');
  const out = join(disk, 'out/ring'), kept = Object.fromEntries(readdirSync(out).map((name) => [name, readFileSync(join(out, name))]));
  const largest = Math.max(...Object.values(kept).map((bytes) => bytes.length));

  // So full that the smaller files of a build still fit, and the largest does not.
  const room = () => { const { bavail, bsize } = statfsSync(disk); return bavail * bsize; };
  writeFileSync(join(disk, 'filler'), Buffer.alloc(room() - Math.floor(largest / 2)));
  writeFileSync(join(disk, 'ring/track.yaml'), `${readFileSync(join(disk, 'ring/track.yaml'), 'utf8')}reverse: true\n`);
  await page.reload();
  await page.waitForSelector('html[data-ready="yes"]');
  await page.waitForSelector('.stage[data-road]');
  await page.click('[data-role="build"]');
  await said('No space left');
  const note = await page.textContent('[data-part="track"] [data-role="note"]');
  check(await page.$eval('[data-part="track"] [data-role="note"]', (box) => box.classList.contains('bad')), `it is said as a failure: ${note}`);
  const now = readdirSync(out).filter((name) => !name.startsWith('.'));
  check(JSON.stringify(now.sort()) === JSON.stringify(Object.keys(kept).sort()), `no file came or went: ${now}`);
  for (const [name, bytes] of Object.entries(kept)) check(existsSync(join(out, name)) && readFileSync(join(out, name)).equals(bytes), `${name} is what it was`);
  check(room() > largest / 3, `what could not be finished takes no room: ${room()} bytes are free`);
  check(await page.$('.stage[data-road]') !== null, 'the road that was built is still shown');

  // Room again: the same click builds.
  rmSync(join(disk, 'filler'));
  await page.click('[data-role="build"]');
  await said('Built.');
  check(!readFileSync(join(out, 'ring.crg')).equals(kept['ring.crg']), 'the road is the new one');
} catch (error) {
  failed(error);
} finally {
  await browser?.close();
  if (served) await end(served.server);
  spawnSync('umount', ['-l', disk]);
  rmSync(dir, { recursive: true });
}
finish();
