// The viewer's page in headless Chromium: it draws the palace, keys move the camera, and a freeze shows the scene from
// outside. `cargo xtask viewer --web` runs it.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

const { chromium } = createRequire(join(process.env.ENFILADE_WEB, 'package.json'))('playwright-core');
const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
// Software rendering takes seconds a frame.
const timeout = 180_000;
let folder;
const ends = [];

before(async () => {
  folder = await mkdtemp(join(tmpdir(), 'enfilade-viewer-'));
});

after(async () => {
  for (const end of ends.reverse()) await end();
  await rm(folder, { recursive: true, force: true });
});

/** Serves a scene, and returns the address. */
async function serve(scene, program = [process.env.ENFILADE_VIEWER]) {
  const [first, ...rest] = program;
  const server = spawn(first, [...rest, '--web', scene]);
  ends.push(() => server.kill());
  for await (const line of server.stdout) {
    return /http:\S+/.exec(String(line))[0];
  }
  throw new Error('the server has ended');
}

async function open(address, { gpu = true, flags = [] } = {}) {
  const profile = await mkdtemp(join(folder, 'profile-'));
  const browser = await chromium.launchPersistentContext(profile, {
    executablePath,
    headless: true,
    viewport: { width: 900, height: 600 },
    args: [
      '--no-sandbox',
      ...(gpu
        ? ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader']
        : ['--disable-gpu', '--disable-3d-apis']),
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--no-first-run',
      '--disable-quic',
      ...flags,
    ],
  });
  ends.push(() => browser.close());
  const page = await browser.newPage();
  page.on('console', (message) => message.type() === 'error' && console.error(message.text()));
  await page.goto(address);
  return page;
}

/** Returns the pixels of the page. */
async function pixels(page) {
  const picture = (await page.screenshot({ timeout })).toString('base64');
  const bytes = await page.evaluate(async (picture) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${picture}`)).blob());
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    return Array.from(new Uint32Array(data.buffer));
  }, picture);
  return bytes;
}

const colors = (pixels) => new Set(pixels).size;
const different = (a, b) => a.filter((pixel, at) => pixel !== b[at]).length;

/** Waits until the pixels of the page are as wanted. */
async function until(page, what, isSo) {
  for (const start = Date.now(); Date.now() - start < timeout; ) {
    const now = await pixels(page);
    if (isSo(now)) return now;
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
  throw new Error(`${what} does not appear`);
}

test('the palace appears, keys move the camera, and a freeze shows it from outside', { timeout: 3 * timeout }, async () => {
  const page = await open(await serve('@enfilade'));
  const start = Date.now();
  await page.waitForFunction(() => document.body.dataset.state, null, { timeout });
  assert.equal(await page.evaluate(() => document.body.dataset.state), 'running', await page.innerText('#note'));
  const first = await until(page, 'the palace', (now) => colors(now) > 5000);
  console.log(`the palace is there after ${((Date.now() - start) / 1000).toFixed(1)} s`);
  if (process.env.ENFILADE_SCREENSHOT) await page.screenshot({ path: process.env.ENFILADE_SCREENSHOT });
  await page.keyboard.down('w');
  await new Promise((resolve) => setTimeout(resolve, 1000));
  await page.keyboard.up('w');
  const moved = await until(page, 'a step forward', (now) => different(first, now) > 50_000);
  await page.keyboard.press('f', { delay: 500 });
  await until(page, 'the frozen set', (now) => different(moved, now) > 5000);
});

test('a file that is no scene is refused before it is served, with the reason', { timeout }, async () => {
  const file = join(folder, 'broken.glb');
  await writeFile(file, 'glTF but not really');
  const server = spawn(process.env.ENFILADE_VIEWER, ['--web', file]);
  let said = '';
  server.stderr.on('data', (text) => (said += text));
  assert.equal(await new Promise((resolve) => server.on('close', resolve)), 2);
  assert.match(said, /broken\.glb: .*glTF/);
});

test('a server with few handles outlives more clients than it has', { timeout }, async () => {
  const address = await serve('@enfilade', ['sh', '-c', 'ulimit -n 40; exec "$0" "$@"', process.env.ENFILADE_VIEWER]);
  const { hostname, port } = new URL(address);
  const clients = Array.from({ length: 200 }, () => connect(Number(port), hostname).on('error', () => {}));
  await new Promise((resolve) => setTimeout(resolve, 1000));
  clients.forEach((client) => client.destroy());
  await new Promise((resolve) => setTimeout(resolve, 1000));
  assert.equal((await fetch(address)).status, 200);
  assert.equal((await fetch(new URL('/', address))).status, 404);
});

test('bytes that are no scene are named, with the reason', { timeout }, async () => {
  const page = await open((await serve('@enfilade')).replace('@enfilade', 'page.js'));
  await page.waitForFunction(() => document.body.dataset.state, null, { timeout });
  await page.waitForFunction(() => document.getElementById('said').textContent, null, { timeout });
  assert.match(await page.innerText('#said'), /page\.js: .*glTF/);
  await until(page, 'a message', (now) => colors(now) > 20);
  if (process.env.ENFILADE_SCREENSHOT) await page.screenshot({ path: `${process.env.ENFILADE_SCREENSHOT}.broken.png` });
});

test('a browser without WebGL is told so', { timeout }, async () => {
  const page = await open(await serve('@enfilade'), { gpu: false });
  await page.waitForFunction(() => document.body.dataset.state, null, { timeout });
  assert.equal(await page.evaluate(() => document.body.dataset.state), 'failed');
  assert.match(await page.innerText('#note'), /neither WebGPU nor WebGL2/);
});

test('a page that runs out of memory says so', { timeout }, async () => {
  // 48 MB, of 64 KiB pages.
  const page = await open(await serve('@enfilade'), { flags: ['--js-flags=--wasm-max-mem-pages=768'] });
  await page.waitForFunction(() => document.body.dataset.state === 'failed', null, { timeout });
  assert.match(await page.innerText('#note'), /may have run out of memory/);
});
