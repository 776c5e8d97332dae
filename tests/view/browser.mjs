// kerbstone view served on a folder, and a headless Chromium that opens it: for the tests of the page.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { existsSync } from 'node:fs';
import { join, resolve } from 'node:path';

/// Machines that build beside it are slow; nothing here waits for long on a calm one.
export const kPatience_ms = 120000;

const chromiumPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);

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

/// A browser in which the processor draws.
export const launch = (require, words = []) => require('playwright-core').chromium.launch({
  executablePath: chromiumPath, headless: true,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--no-first-run', ...words],
});
