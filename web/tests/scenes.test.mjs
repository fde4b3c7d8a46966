// Walks through real scenes, on both renderers: pictures, draw calls, triangles and times, with and without culling.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test, { after, before } from 'node:test';
import { browse, scenes } from './browser.mjs';

const paths = JSON.parse(readFileSync(new URL('paths.json', import.meta.url)));
const frames = Number(process.env.FRAMES ?? 60);
const rows = [];

let browser;
before(async () => {
  browser = await browse();
});
after(async () => {
  await browser.close();
  console.log(`\n${frames} frames each; before → with culling; "differing": pixels that differ, of all frames together\n`);
  console.log('| scene | renderer | draw calls | triangles | look ms (first) | compare ms | frame ms | differing | false culls |\n|---|---|---|---|---|---|---|---|---|');
  for (const { name, kind, antialias, found } of rows) {
    const pair = ([whole, culled]) => `${whole.toFixed(0)} → ${culled.toFixed(0)}`;
    const [look, first, sync] = [found.lookMs, found.firstLookMs, found.syncMs].map((time) => time.toFixed(1));
    const renderer = `${kind}${antialias ? ', antialias' : ''}`;
    const { calls, triangles, ms, pixels, falseCulls } = found;
    console.log(`| ${name} | ${renderer} | ${pair(calls)} | ${pair(triangles)} | ${look} (${first}) | ${sync} | ${pair(ms)} | ${pixels} | ${falseCulls.length} |`);
  }
});

for (const name of [...Object.keys(paths), 'a hall of 10,000 instances']) {
  for (const [kind, antialias] of [['webgl', true], ['webgl', false], ['webgpu', true]]) {
    test(`${name} on ${kind}${antialias ? ' with antialiasing' : ''}`, { skip: name in paths && !scenes, timeout: 600_000 }, async () => {
      const { page, errors } = await browser.open('tests/page.html');
      await page.waitForFunction('window.ready');
      const found = await page.evaluate(
        async ([name, stops, kind, antialias, frames]) => {
          const renderer = await createRenderer(kind, { antialias });
          const { scene, camera, at } = stops ? await world(`/scenes/${name}.glb`, stops) : hall(10_000);
          const culler = await EnfiladeCuller.load({ renderer });
          culler.addScene(scene);
          const compared = await compare(renderer, scene, camera, culler, frames, (frame) => at(frame, frames));
          culler.dispose();
          return compared;
        },
        [name, paths[name], kind, antialias, frames],
      );
      rows.push({ name, kind, antialias, found });
      assert.deepEqual([found.falseCulls, errors], [[], []]);
      assert.ok(found.pixels <= 1e-4 * found.size * frames, `${found.pixels} pixels differ`);
      assert.ok(found.triangles[1] < 0.9 * found.triangles[0], `${found.triangles}`);
      await page.close();
    });
  }
}
