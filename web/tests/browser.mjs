// Serves this folder on localhost, and opens pages of it in headless Chromium.
import { existsSync, createReadStream, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';

const types = { '.html': 'text/html', '.css': 'text/css', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm' };
const root = fileURLToPath(new URL('..', import.meta.url));

/** Folder of the real scenes, if there is one. */
export const scenes = process.env.ENFILADE_SCENES;

/** Starts a server for files of this folder, and of the real scenes under `/scenes/`. */
async function serve() {
  const server = createServer((request, response) => {
    const { pathname } = new URL(request.url, 'http://localhost');
    const path = normalize(decodeURIComponent(pathname));
    const file = path.startsWith('/scenes/') && scenes ? join(scenes, path.slice(8)) : join(root, path);
    if (path.includes('..') || !existsSync(file) || !statSync(file).isFile()) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream' });
    createReadStream(file).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { server, address: `http://127.0.0.1:${server.address().port}` };
}

/** Opens pages in one browser. Call `close` at the end. */
export async function browse() {
  const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
  const { server, address } = await serve();
  const profile = await mkdtemp(join(tmpdir(), 'enfilade-web-'));
  const browser = await chromium.launchPersistentContext(profile, {
    executablePath,
    headless: true,
    viewport: { width: 800, height: 450 },
    args: [
      '--no-sandbox',
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--no-first-run',
      '--disable-quic',
    ],
  });
  return {
    /** Opens a page of this folder; what it logs as an error, or throws, is in `errors`. */
    async open(path) {
      const page = await browser.newPage();
      const errors = [];
      const warnings = [];
      page.on('pageerror', (error) => errors.push(String(error)));
      page.on('console', (message) => {
        if (message.type() === 'error') {
          errors.push(message.text());
        } else if (message.type() === 'warning') {
          warnings.push(message.text());
        }
      });
      await page.goto(`${address}/${path}`);
      return { page, errors, warnings };
    },
    async close() {
      await browser.close();
      server.close();
      await rm(profile, { recursive: true, force: true });
    },
  };
}
