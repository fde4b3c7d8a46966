// The module without a renderer, in Node.js.
import assert from 'node:assert/strict';
import test from 'node:test';
import { load, Scene, Viewer } from '../dist/index.js';

await load();

const quad = { positions: new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]), indices: new Uint16Array([0, 1, 2, 0, 2, 3]) };

function at(...places) {
  const matrices = new Float32Array(16 * places.length);
  places.forEach(([x, y, z, scale], number) => {
    matrices.set([scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, x, y, z, 1], 16 * number);
  });
  return matrices;
}

/** Columns of a projection with a field of view of 90 degrees, and a near plane at 0.1. */
const projection = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.002, -1, 0, 0, -0.2002, 0];
const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const look = (viewer, scene, options) => viewer.look(scene, identity, projection, { width: 256, height: 256, ...options });

test('a wall hides what is behind it until it is moved aside', () => {
  const scene = new Scene();
  const mesh = scene.addMesh(quad);
  scene.add([3, 40], [mesh, mesh], at([0, 0, -5, 3], [0, 0, -9, 1]));
  const viewer = new Viewer();
  look(viewer, scene);
  assert.deepEqual([...viewer.visible], [3]);
  assert.equal(viewer.sees(40), false);
  scene.setTransforms([3], at([9, 0, -5, 3]));
  look(viewer, scene);
  assert.deepEqual([...viewer.visible], [40]);
  assert.deepEqual([[...viewer.entered], [...viewer.left]], [[40], [3]]);
  assert.equal(viewer.sees(40) && !viewer.sees(1 << 20), true);
});

test('glass, boxes, hidden layers and removed walls hide nothing', () => {
  for (const change of ['glass', 'box', 'layers', 'removed', 'back', 'not an occluder']) {
    const scene = new Scene();
    const mesh = scene.addMesh(quad);
    const group = { start: 0, count: 6, seeThrough: change === 'glass', side: change === 'back' ? 'back' : 'front' };
    const wall = change === 'box' ? scene.addBox([-1, -1, 0], [1, 1, 0]) : scene.addMesh({ ...quad, groups: [group] });
    scene.add([0, 1], [wall, mesh], at([0, 0, -5, 3], [0, 0, -9, 1]), [
      { layers: change === 'layers' ? 2 : 0xffffffff, occluder: change !== 'not an occluder' },
      {},
    ]);
    if (change === 'removed') {
      scene.remove([0]);
    }
    const viewer = new Viewer();
    look(viewer, scene, { layers: 1 });
    assert.equal(viewer.sees(1), true, change);
  }
});

test('an object without a position counts as visible until it has one', () => {
  const scene = new Scene();
  const mesh = scene.addMesh(quad);
  scene.add([0, 1], [mesh, mesh], at([0, 0, -5, 1], [NaN, 0, 5, 1]));
  const viewer = new Viewer();
  look(viewer, scene);
  assert.deepEqual([...viewer.visible], [0, 1]);
  scene.setTransforms([1], at([0, 0, -9, 0.5]));
  look(viewer, scene);
  assert.deepEqual([...viewer.visible], [0]);
  // What hid it is gone, who knows where.
  scene.setTransforms([0], at([Infinity, 0, 0, 1]));
  look(viewer, scene);
  assert.deepEqual([...viewer.visible], [0, 1]);
});

test('errors have codes', () => {
  const scene = new Scene();
  const mesh = scene.addMesh(quad);
  const viewer = new Viewer();
  const code = (run) => {
    try {
      run();
      return undefined;
    } catch (error) {
      return error.code;
    }
  };
  const nan = new Float32Array([NaN, 0, 0, 1, 0, 0, 0, 1, 0]);
  const flat = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, -0.02, 0, 0, 0, -1, 1];
  assert.deepEqual(
    [
      code(() => scene.addMesh({ positions: nan })),
      code(() => scene.addMesh({ positions: quad.positions, indices: new Uint16Array([0, 1, 9]) })),
      code(() => scene.add([0], [99], at([0, 0, 0, 1]))),
      code(() => scene.add([0], [mesh], new Float32Array(15))),
      code(() => scene.add([1 << 30], [mesh], at([0, 0, 0, 1]))),
      code(() => viewer.look(scene, identity, flat, { width: 64, height: 64 })),
      code(() => viewer.look(scene, identity, identity.map(() => NaN), { width: 64, height: 64 })),
      code(() => viewer.look(scene, identity, projection, { width: 0, height: 64 })),
    ],
    ['mesh/not-finite', 'mesh/index-out-of-range', 'web/no-mesh', 'web/length', 'web/key', 'view/singular', 'view/not-finite', 'view/size'],
  );
  for (const wrong of [() => scene.add(['a'], [mesh], at([0, 0, 0, 1])), () => scene.add([0], [undefined], at([0, 0, 0, 1])), () => scene.remove([1.5]), () => viewer.look(scene, identity, projection)]) {
    assert.throws(wrong, { name: 'TypeError', message: /^enfilade: / });
  }
  look(viewer, scene);
});

test('ten thousand random changes leave what a new scene has', () => {
  const roll = ((state) => () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32)(7);
  const scene = new Scene();
  const meshes = [scene.addMesh(quad), scene.addBox([-1, -1, -1], [1, 1, 1])];
  const state = new Map();
  const place = () => [20 * roll() - 10, 20 * roll() - 10, -1 - 30 * roll(), 0.1 + 2 * roll()];
  for (let round = 0; round < 100; round++) {
    const [added, moved, removed] = [new Map(), new Map(), []];
    for (let number = 0; number < 100; number++) {
      const key = Math.floor(roll() * 500);
      if (!state.has(key)) {
        added.set(key, { mesh: Math.floor(roll() * 2), at: place() });
        state.set(key, added.get(key));
      } else if (roll() < 0.5) {
        state.get(key).at = place();
        moved.set(key, state.get(key).at);
      } else if (!added.has(key)) {
        state.delete(key);
        moved.delete(key);
        removed.push(key);
      }
    }
    scene.remove(removed);
    const back = [...added].filter(([key]) => state.has(key));
    scene.add(back.map(([key]) => key), back.map(([, { mesh }]) => meshes[mesh]), at(...back.map(([, { at }]) => at)));
    scene.setTransforms([...moved.keys()], at(...moved.values()));
  }
  const fresh = new Scene();
  const others = [fresh.addMesh(quad), fresh.addBox([-1, -1, -1], [1, 1, 1])];
  const all = [...state];
  fresh.add(all.map(([key]) => key), all.map(([, { mesh }]) => others[mesh]), at(...all.map(([, { at }]) => at)));
  const [a, b] = [new Viewer(), new Viewer()];
  look(a, scene);
  look(b, fresh);
  assert.equal(scene.itemCount, state.size);
  assert.ok(a.visible.length > 20 && a.visible.length < state.size, `${a.visible.length} of ${state.size}`);
  assert.deepEqual([...a.visible], [...b.visible]);
});
