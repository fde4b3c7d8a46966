// The module without SIMD: the same visible sets as with it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import { load, Scene, Viewer } from '../dist/index.js';

/** Looks at random walls and boxes from the origin, and returns a hash of what is visible. */
function hashOfLooks() {
  let state = 11;
  const roll = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
  const scene = new Scene();
  const wall = scene.addMesh({ positions: new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]), indices: new Uint16Array([0, 1, 2, 0, 2, 3]) });
  const box = scene.addBox([-1, -1, -1], [1, 1, 1]);
  const count = 2000;
  const transforms = new Float32Array(16 * count);
  for (let number = 0; number < count; number++) {
    const [x, y, z, s] = [60 * roll() - 30, 30 * roll() - 15, -2 - 60 * roll(), 0.2 + 3 * roll() ** 3];
    transforms.set([s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, x, y, z, 1], 16 * number);
  }
  const keys = Array.from({ length: count }, (_, number) => number);
  scene.add(keys, keys.map((key) => (key % 2 ? wall : box)), transforms);
  const hash = createHash('sha256');
  for (const tightness of ['boxes', 'faces', 'resolved']) {
    const viewer = new Viewer({ tightness });
    for (let look = 0; look < 20; look++) {
      const [c, s] = [Math.cos(look / 8 - 1), Math.sin(look / 8 - 1)];
      viewer.look(scene, [c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, -1.002, -1, 0, 0, -0.2002, 0], { width: 480, height: 320 });
      hash.update(viewer.visible.slice());
    }
  }
  return hash.digest('hex');
}

if (process.argv[2] === 'plain') {
  await load({ simd: false });
  process.stdout.write(hashOfLooks());
} else {
  test('sixty looks without SIMD see what those with it see', { timeout: 120_000 }, async () => {
    await load({ simd: true });
    const plain = execFileSync(process.execPath, [fileURLToPath(import.meta.url), 'plain'], { encoding: 'utf8' });
    assert.equal(plain, hashOfLooks());
  });
}
