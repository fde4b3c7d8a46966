// The demo pages: they load without an error, and draw much less with culling than without.
import assert from 'node:assert/strict';
import test, { after, before } from 'node:test';
import { browse } from './browser.mjs';

let browser;
before(async () => {
  browser = await browse();
});
after(() => browser.close());

for (const path of ['walk.html?scene=city', 'walk.html?scene=hall', 'walk.html', 'bim.html']) {
  test(path, { timeout: 240_000 }, async () => {
    const { page, errors } = await browser.open(`demo/dist/${path}`);
    await page.setViewportSize({ width: 320, height: 180 });
    await page.waitForFunction('window.culler?.stats.active', { timeout: 60_000 });
    const calls = await page.evaluate(async () => {
      const drawn = () => {
        renderer.render(scene, camera);
        return renderer.info.render.triangles;
      };
      renderer.setAnimationLoop(null);
      culler.update(camera);
      const culled = drawn();
      culler.enabled = false;
      return [culled, drawn()];
    });
    assert.ok(calls[0] > 0 && 2 * calls[0] < calls[1], `${calls}`);
    assert.deepEqual(errors, []);
    await page.close();
  });
}

test('a click on an element tells its globalId', { timeout: 120_000 }, async () => {
  const { page, errors } = await browser.open('demo/dist/bim.html');
  await page.setViewportSize({ width: 800, height: 450 });
  await page.waitForFunction('window.culler?.stats.active', { timeout: 60_000 });
  await page.mouse.click(600, 300);
  const text = await page.textContent('#element');
  assert.match(text, /globalId [0-3][0-9A-Za-z_$]{21}\n/);
  assert.deepEqual(errors, []);
  await page.close();
});

test('plain WebGL draws a part of the palace', { timeout: 120_000 }, async () => {
  const { page, errors } = await browser.open('demo/dist/plain.html');
  await page.setViewportSize({ width: 320, height: 180 });
  await page.waitForFunction('document.body.dataset.calls', undefined, { timeout: 60_000 });
  const counts = await page.textContent('#counts');
  const [, drawn, all] = counts.replaceAll(',', '').match(/triangles +(\d+) of (\d+)/);
  assert.ok(drawn > 1000 && 4 * drawn < all, counts);
  assert.deepEqual(errors, []);
  await page.close();
});
