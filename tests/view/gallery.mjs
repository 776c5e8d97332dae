// Pictures of docs/gallery.md, of what `kerbstone try -o TOUR --seed 1 --no-open` made.
// usage: node gallery.mjs KERBSTONE TOUR SOURCE [FOLDER]; exit 77: skipped.
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { end, launch, opened, packagesOf, serve } from './browser.mjs';

const [kerbstone, tour, source, folder = join(source, 'docs/pictures')] = process.argv.slice(2);
const require = packagesOf(source), browser = await launch(require);
const { page, until } = await opened(browser, require, folder, { viewport: { width: 1200, height: 760 } });
/// Once all that it asked for is done and drawn.
async function take(name) {
  await page.waitForTimeout(2000);
  await until(() => ![...document.querySelectorAll('button')].some((button) => button.textContent === 'Stop'));
  await page.waitForTimeout(2000);
  await page.screenshot({ path: join(folder, `gallery-${name}.png`) });
}

for (const part of ['road', 'found']) {
  await page.goto(String(pathToFileURL(resolve(tour, part, 'report.html'))));
  if (part === 'found') await page.evaluate(() => [...document.querySelectorAll('h2')].find((head) => head.textContent.includes('parameter.')).scrollIntoView());
  await take(part);
}
const served = await serve(kerbstone, tour);
await page.goto(served.address);
await page.waitForSelector('html[data-ready="yes"]');
for (const [tab, file] of [['track', 'mesh/kerbstone-ring.obj'], ['laps', 'recording.csv'], ['scans', 'scans/scan_000.ply']]) {
  await page.click(`[data-tab="${tab}"]`);
  await page.click(`[data-id="0/${file}"]`);
  if (tab === 'scans') await page.getByText('Make tiles').click();
  await take(tab);
}
await browser.close();
await end(served.server);
