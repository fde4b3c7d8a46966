// A walk through rooms in headless Chromium: the same pictures with a fifth of the draw calls.
import assert from 'node:assert/strict';
import test from 'node:test';
import { browse } from './browser.mjs';

test('rooms look the same with a fifth of the draw calls', { timeout: 120_000 }, async () => {
  const browser = await browse();
  try {
    const { page, errors } = await browser.open('tests/page.html');
    await page.waitForFunction('window.ready');
    for (const kind of ['webgl', 'webgpu']) {
      const found = await page.evaluate(async (kind) => {
        const renderer = await createRenderer(kind);
        const { scene, camera, at } = rooms(36, 1500);
        const culler = await EnfiladeCuller.load({ renderer });
        culler.addScene(scene);
        const compared = await compare(renderer, scene, camera, culler, 12, (frame) => at(frame, 12));
        culler.dispose();
        renderer.dispose();
        renderer.domElement.remove();
        return compared;
      }, kind);
      assert.deepEqual([found.pixels, found.falseCulls], [0, []], kind);
      assert.ok(5 * found.calls[1] < found.calls[0], `${kind}: ${found.calls}`);
    }
    assert.deepEqual(errors, []);
  } finally {
    await browser.close();
  }
});
