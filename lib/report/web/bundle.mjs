// Bundles src/ and the npm packages into one page without references to anything outside it.
// usage: node bundle.mjs OUTPUT.html [SOURCES]; SOURCES: the folder with main.js, style.css, page.html, else src/
import { build } from 'esbuild';
import { readFile, rename, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { deflateSync } from 'node:zlib';

const output = process.argv[2];
if (!output) {
  console.error('bundle.mjs: no output given; usage: node bundle.mjs OUTPUT.html [SOURCES]');
  process.exit(2);
}
const here = dirname(fileURLToPath(import.meta.url));
const sources = process.argv[3] ?? join(here, 'src');
const nodePaths = [join(here, 'node_modules')];  // for sources elsewhere
const result = await build({
  entryPoints: [join(sources, 'main.js')],
  bundle: true,
  nodePaths,
  minify: true,
  format: 'iife',
  target: ['chrome100', 'firefox113', 'safari16.4'],
  charset: 'ascii',
  legalComments: 'inline',
  write: false,
  logLevel: 'warning',
});
const style = await build({
  entryPoints: [join(sources, 'style.css')],
  bundle: true,
  nodePaths,
  minify: true,
  write: false,
  logLevel: 'warning',
});
const page = await readFile(join(sources, 'page.html'), 'utf8');
// Functions as replacements: '$&' and the like in a library must stay what they are.
const script = result.outputFiles[0].text.replaceAll('</script', '<\\/script').replaceAll('<!--', '<\\!--');
const html = page
  .replace('@STYLE@', () => style.outputFiles[0].text)
  .replace('@SCRIPT@', () => script)
  .replace('@PACKED_SCRIPT@', () => deflateSync(result.outputFiles[0].contents, { level: 9 }).toString('base64'));
await writeFile(output + '.new', html);
await rename(output + '.new', output);
