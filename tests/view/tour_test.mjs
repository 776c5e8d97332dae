// The first start, in an empty folder, by keyboard alone: the tour makes the demo circuit, its recipe, its road, and shows the report.
// usage: node tour_test.mjs KERBSTONE SOURCE; exit 77: skipped.
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { check, end, failed, finish, launch, opened, packagesOf, serve } from './browser.mjs';

const [kerbstone, source, shots] = process.argv.slice(2);
const require = packagesOf(source);

const dir = mkdtempSync(join(tmpdir(), 'kerbstone-tour-')), served = await serve(kerbstone, dir), browser = await launch(require);
let page;
try {
  const { problems, picture, accessible, ...rest } = await opened(browser, require, shots);
  page = rest.page;
  const step = (number) => page.waitForSelector(`.tour[data-step="${number}"]`);
  const enter = async (role) => { await page.focus(`[data-role="${role}"]`); await page.keyboard.press('Enter'); };
  await page.goto(served.address);
  await page.waitForSelector('html[data-ready="yes"]');
  await step(0);
  check(await page.evaluate(() => document.activeElement?.dataset.role) === 'tour-act', 'the tour begins by itself where there is nothing yet, and the keyboard is in it');
  await accessible('tour');
  await page.keyboard.press('Enter');
  await step(1);
  check(existsSync(join(dir, 'demo/kerbstone-ring.obj')), 'the mesh of the demo is there');
  await page.waitForSelector('.stage[data-parts]');
  await picture('tour-mesh');
  await enter('tour-act');
  await page.waitForFunction(() => document.querySelector('[data-role="recipe"]').value.includes('mesh: kerbstone-ring.obj'));
  await enter('tour-next');
  await step(2);
  await enter('tour-act');
  await page.waitForSelector('.stage[data-road="0/out/kerbstone-ring/kerbstone-ring.crg"]');
  await enter('tour-next');
  await step(3);
  await page.waitForSelector('iframe[data-report="0/out/kerbstone-ring/report.html"]');
  await picture('tour-road');
  for (const number of [4, 5, 6]) {
    await enter('tour-next');
    await step(number);
  }
  await enter('tour-next');
  check(await page.$eval('.tour', (box) => box.hidden), 'and it ends');
  await page.click('[data-role="tour"]');
  await step(0);
  await page.keyboard.press('Escape');
  check(await page.$eval('.tour', (box) => box.hidden), 'Escape closes it');
  check(problems.length === 0, problems.join(' | '));
} catch (error) {
  failed(error);
  if (shots) await page?.screenshot({ path: join(shots, 'tour-failed.png') });
} finally {
  await browser.close();
  await end(served.server);
  rmSync(dir, { recursive: true });
}
finish();
