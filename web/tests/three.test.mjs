// Every kind of object and camera of three.js, in headless Chromium, on both renderers.
import assert from 'node:assert/strict';
import test, { after, before } from 'node:test';
import { browse } from './browser.mjs';

let browser;
before(async () => {
  browser = await browse();
});
after(() => browser.close());

/** Runs `story(renderer, kind)` in a page, for each renderer, and checks that it logged no error. */
function onBoth(name, story, check, { warns = false } = {}) {
  test(name, { timeout: 120_000 }, async () => {
    for (const kind of ['webgl', 'webgpu']) {
      const { page, errors, warnings } = await browser.open('tests/page.html');
      await page.waitForFunction('window.ready');
      const found = await page.evaluate(
        `(async () => { const renderer = await createRenderer('${kind}'); return (${story})(renderer, '${kind}'); })()`,
      );
      check(found, kind);
      assert.deepEqual(errors, [], kind);
      const ours = warnings.filter((text) => text.startsWith('enfilade'));
      assert.equal(ours.length > 0, warns, `${kind}: ${ours}`);
      await page.close();
    }
  });
}

/** No false cull; a few pixels may differ where vertices were moved: see `falseCull`. */
const same = ({ pixels, falseCulls, size, frames }) => {
  assert.deepEqual(falseCulls, []);
  assert.ok(pixels <= 1e-5 * size * frames, `${pixels} pixels of ${frames} frames differ`);
};

onBoth(
  'instances and batched objects are culled one by one',
  async (renderer) => {
    const out = {};
    for (const what of ['instanced', 'batched']) {
      const { scene, camera, at } = rooms(36, 0);
      const roll = random(3);
      const count = 3000;
      const shapes = [new THREE.BoxGeometry(0.3, 0.3, 0.3), new THREE.SphereGeometry(0.2, 12, 8)];
      const material = new THREE.MeshLambertMaterial();
      const all = what === 'instanced' ? new THREE.InstancedMesh(shapes[0], material, count) : new THREE.BatchedMesh(count, 500, 2000, material);
      const ids = what === 'batched' && shapes.map((shape) => all.addGeometry(shape));
      const matrix = new THREE.Matrix4();
      const color = new THREE.Color();
      const gone = new Set();
      for (let number = 0; number < count; number++) {
        const id = ids ? all.addInstance(ids[number % 2]) : number;
        all.setMatrixAt(id, matrix.makeTranslation(36 * roll() - 3, 0.2 + 2 * roll(), 36 * roll() - 3));
        all.setColorAt(id, color.setHSL(roll(), 0.7, 0.5));
      }
      all.position.set(0.1, 0, 0);
      scene.add(all);
      const culler = await EnfiladeCuller.load({ renderer });
      culler.addScene(scene);
      const still = await compare(renderer, scene, camera, culler, 12, (frame) => at(frame, 12));
      // Some move, some change their colour, some appear, some go.
      const moving = await compare(renderer, scene, camera, culler, 8, (frame) => {
        at(frame, 8);
        for (let number = frame; number < count; number += 7) {
          if (gone.has(number)) {
            continue;
          }
          all.setMatrixAt(number, matrix.makeTranslation(36 * roll() - 3, 0.2 + 2 * roll(), 36 * roll() - 3));
        }
        if (what === 'instanced') {
          all.instanceMatrix.needsUpdate = true;
          all.count = count - 100 * frame;
        } else {
          all.setVisibleAt(5 * frame, false);
          all.deleteInstance(5 * frame + 1);
          gone.add(5 * frame + 1);
        }
      });
      const children = scene.children.length;
      culler.dispose();
      out[what] = { still, moving, left: [all.children.length, Object.hasOwn(all, 'intersectsFrustum'), scene.children.length - children] };
    }
    return out;
  },
  ({ instanced, batched }, kind) => {
    for (const [name, { still, moving, left }] of Object.entries({ instanced, batched })) {
      same(still);
      same(moving);
      assert.ok(still.stats.hidden > 2000, `${name} on ${kind}: ${JSON.stringify(still.stats)}`);
      assert.deepEqual(left, [0, false, 0], name);
    }
    assert.ok(instanced.still.triangles[1] < 0.6 * instanced.still.triangles[0], `${kind}: ${instanced.still.triangles}`);
  },
);

onBoth(
  'a thing behind a wall is skipped, and only if the wall is one',
  async (renderer) => {
    const kinds = {
      opaque: {},
      'seen from its back': { side: THREE.BackSide },
      'of two sides': { side: THREE.DoubleSide },
      transparent: { transparent: true, opacity: 0.5 },
      'alpha-tested': { alphaTest: 0.5 },
      'alpha-hashed': { alphaHash: true },
      'without depth': { depthWrite: false },
      'drawn over all': { depthTest: false },
      invisible: { visible: false },
      wireframe: { wireframe: true },
      additive: { blending: THREE.AdditiveBlending },
      stencilled: { stencilWrite: true },
      'without colour': { colorWrite: false },
      clipped: { clippingPlanes: [new THREE.Plane(new THREE.Vector3(0, 1, 0), 0)] },
      'pushed back': { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 },
      displaced: { displacementMap: new THREE.DataTexture(new Uint8Array([255, 255, 255, 255]), 1, 1), displacementScale: -3 },
    };
    renderer.localClippingEnabled = true;
    const hidden = {};
    const add = async (name, wall, thing, options) => {
      const scene = new THREE.Scene();
      const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, 100);
      wall.position.z = -5;
      thing.position.z = -9;
      scene.add(wall, thing);
      const culler = await EnfiladeCuller.load({ renderer });
      culler.addScene(scene);
      if (options) {
        culler.add(wall, options);
      }
      const { pixels } = await compare(renderer, scene, camera, culler, 1, () => {});
      hidden[name] = pixels === 0 && !culler.isVisible(thing, camera);
      if (pixels > 0) {
        hidden[name] = `${pixels} pixels differ`;
      }
      culler.dispose();
    };
    const plane = () => new THREE.PlaneGeometry(8, 8);
    const thing = () => new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), new THREE.MeshBasicMaterial({ color: 0xff0000 }));
    for (const [name, parameters] of Object.entries(kinds)) {
      await add(name, new THREE.Mesh(plane(), new THREE.MeshStandardMaterial(parameters)), thing());
    }
    const basic = () => new THREE.MeshBasicMaterial({ color: 0x00ff00 });
    await add('trusted', new THREE.Mesh(plane(), new THREE.MeshBasicMaterial({ transparent: true, opacity: 1 })), thing(), { occluder: true });
    await add('distrusted', new THREE.Mesh(plane(), basic()), thing(), { occluder: false });
    const compiled = basic();
    compiled.onBeforeCompile = () => {};
    await add('with a shader of its own', new THREE.Mesh(plane(), compiled), thing());
    const unculled = new THREE.Mesh(plane(), basic());
    unculled.frustumCulled = false;
    await add('never culled', unculled, thing());
    const window = plane();
    window.clearGroups();
    window.addGroup(0, 3, 0);
    window.addGroup(3, 3, 1);
    await add('half of glass', new THREE.Mesh(window, [basic(), new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.4 })]), thing());
    const part = plane();
    part.setDrawRange(0, 3);
    await add('half drawn', new THREE.Mesh(part, basic()), thing());
    const morphed = plane();
    const target = morphed.attributes.position.clone();
    for (let vertex = 0; vertex < target.count; vertex++) {
      target.setX(vertex, target.getX(vertex) + 20);
    }
    morphed.morphAttributes.position = [target];
    const moving = new THREE.Mesh(morphed, basic());
    moving.morphTargetInfluences[0] = 1;
    await add('morphed away', moving, thing());
    const mirrored = new THREE.Mesh(plane(), basic());
    mirrored.scale.x = -1;
    await add('mirrored', mirrored, thing());
    const packed = plane();
    const array = new Int8Array([...packed.attributes.position.array].flatMap((value, number) => (number % 3 === 2 ? [value * 31, 0] : [value * 31])));
    packed.setAttribute('position', new THREE.InterleavedBufferAttribute(new THREE.InterleavedBuffer(array, 4), 3, 0, true));
    await add('quantized', new THREE.Mesh(packed, basic()), thing());
    const over = thing();
    over.material.depthTest = false;
    await add('thing drawn over all', new THREE.Mesh(plane(), basic()), over);
    const decal = thing();
    Object.assign(decal.material, { polygonOffset: true, polygonOffsetUnits: -1e6, polygonOffsetFactor: -1 });
    await add('thing pulled forward', new THREE.Mesh(plane(), basic()), decal);
    return hidden;
  },
  (hidden) => {
    const expected = { opaque: true, 'of two sides': true, trusted: true, mirrored: true, quantized: true };
    for (const [name, isHidden] of Object.entries(hidden)) {
      assert.equal(isHidden, expected[name] ?? false, name);
    }
    assert.equal(Object.keys(hidden).length, 27);
  },
);

onBoth(
  'skinned, morphed and displaced objects are skipped behind a wall, and drawn where their pose puts them',
  async (renderer) => {
    const scene = new THREE.Scene();
    scene.background = new THREE.Color(0x333333);
    const wall = new THREE.Mesh(new THREE.PlaneGeometry(6, 3), new THREE.MeshBasicMaterial({ color: 0x888888 }));
    wall.position.z = -5;
    const geometry = new THREE.BoxGeometry(0.6, 2, 0.6, 1, 4, 1);
    const { count } = geometry.attributes.position;
    const indices = new Uint16Array(4 * count);
    const weights = new Float32Array(4 * count);
    for (let vertex = 0; vertex < count; vertex++) {
      const part = geometry.attributes.position.getY(vertex) / 2 + 0.5;
      indices.set([0, 1, 0, 0], 4 * vertex);
      weights.set([1 - part, part, 0, 0], 4 * vertex);
    }
    geometry.setAttribute('skinIndex', new THREE.BufferAttribute(indices, 4));
    geometry.setAttribute('skinWeight', new THREE.BufferAttribute(weights, 4));
    const bones = [new THREE.Bone(), new THREE.Bone()];
    bones[0].position.y = -1;
    bones[1].position.y = 2;
    bones[0].add(bones[1]);
    const skinned = new THREE.SkinnedMesh(geometry, new THREE.MeshBasicMaterial({ color: 0xff4444 }));
    skinned.add(bones[0]);
    skinned.bind(new THREE.Skeleton(bones));
    skinned.position.set(-1, 0, -8);
    const morphing = new THREE.BoxGeometry(0.5, 0.5, 0.5);
    const target = morphing.attributes.position.clone();
    for (let vertex = 0; vertex < target.count; vertex++) {
      target.setY(vertex, target.getY(vertex) + 3.2);
    }
    morphing.morphAttributes.position = [target];
    const morphed = new THREE.Mesh(morphing, new THREE.MeshBasicMaterial({ color: 0x44ff44 }));
    morphed.position.set(1, 0, -8);
    scene.add(wall, skinned, morphed);
    // three.js itself tests the bounds of the first pose.
    skinned.boundingSphere = new THREE.Sphere(new THREE.Vector3(), 50);
    morphing.boundingSphere = new THREE.Sphere(new THREE.Vector3(), 50);
    const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, 100);
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    const seen = [];
    const result = await compare(renderer, scene, camera, culler, 12, (frame) => {
      bones[1].position.y = frame < 4 ? 2 : 2 + frame;
      morphed.morphTargetInfluences[0] = frame < 8 ? 0 : (frame - 7) / 4;
      seen.push([culler.isVisible(skinned), culler.isVisible(morphed)]);
    });
    return { result, seen, hiddenAtFirst: seen[1], visibleAtLast: [culler.isVisible(skinned), culler.isVisible(morphed)] };
  },
  ({ result, hiddenAtFirst, visibleAtLast }) => {
    same(result);
    assert.deepEqual([hiddenAtFirst, visibleAtLast], [[false, false], [true, true]]);
  },
);

onBoth(
  'objects that moved, changed, came or went without a call are never culled as they were',
  async (renderer) => {
    const { scene, camera, at } = rooms(16, 600);
    const roll = random(9);
    const things = scene.children.filter(({ name }) => name === 'thing');
    const walls = scene.children.filter(({ name }) => name === 'wall');
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    const group = new THREE.Group();
    scene.add(group);
    const result = await compare(renderer, scene, camera, culler, 100, (frame) => {
      at(frame, 100);
      const any = (list) => list[Math.floor(roll() * list.length)];
      any(things).position.set(18 * roll(), 1, 18 * roll());
      any(walls).position.y = 4 * roll();
      any(things).visible = roll() < 0.7;
      any(walls).visible = roll() < 0.7;
      any(things).layers.set(roll() < 0.2 ? 3 : 0);
      any(walls).material = new THREE.MeshLambertMaterial({ color: 0xffffff * roll(), transparent: roll() < 0.5, opacity: 0.6 });
      any(things).removeFromParent();
      group.add(any(things));
      group.position.x = 0.2 * roll();
      const more = new THREE.Mesh(any(things).geometry, any(things).material);
      more.position.set(18 * roll(), 1, 18 * roll());
      more.scale.setScalar(0.4);
      group.add(more);
      const cloned = any(things);
      cloned.geometry = cloned.geometry.clone().translate(0, roll(), 0);
      const { position } = any(things).geometry.attributes;
      if (frame % 10 === 5) {
        position.setY(3, position.getY(3) + 0.2);
        position.needsUpdate = true;
      }
    });
    // Moved after the update, before it is drawn.
    culler.update(camera);
    const hidden = culler.hiddenObjects(camera)[0];
    hidden.position.copy(camera.position).add(camera.getWorldDirection(new THREE.Vector3()));
    const late = await shoot(renderer, scene, camera);
    culler.enabled = false;
    const whole = await shoot(renderer, scene, camera);
    return { result, late: differences(late.pixels, whole.pixels).length };
  },
  ({ result, late }) => {
    same(result);
    assert.equal(late, 0);
  },
);

onBoth(
  'a wall that is edited hides nothing that shows through it',
  async (renderer) => {
    const edits = {
      'other positions in place': (wall) => {
        wall.geometry.attributes.position.array.fill(0, 3, 6);
        wall.geometry.attributes.position.needsUpdate = true;
      },
      'another attribute': (wall) => {
        const half = wall.geometry.attributes.position.clone();
        half.array.fill(0, 3, 6);
        wall.geometry.setAttribute('position', half);
      },
      'scaled in place': (wall) => wall.geometry.scale(0.2, 0.2, 1),
      'another geometry': (wall) => (wall.geometry = new THREE.PlaneGeometry(0.5, 0.5)),
      'another index': (wall) => wall.geometry.setIndex([0, 2, 1]),
      'half drawn': (wall) => wall.geometry.setDrawRange(0, 3),
      'another material': (wall) => (wall.material = new THREE.MeshBasicMaterial({ alphaTest: 0.5, opacity: 0.2 })),
      'a changed material': (wall) => Object.assign(wall.material, { transparent: true, opacity: 0.2 }),
      wireframe: (wall) => (wall.material.wireframe = true),
      groups: (wall) => {
        wall.geometry.clearGroups();
        wall.geometry.addGroup(0, 3, 0);
        wall.material = [wall.material];
      },
      hidden: (wall) => (wall.visible = false),
      'in another layer': (wall) => wall.layers.set(3),
      scaled: (wall) => wall.scale.setScalar(0.1),
      removed: (wall) => wall.removeFromParent(),
      'all of another material': (wall) => (wall.parent.overrideMaterial = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.5 })),
    };
    const pixels = {};
    for (const [name, edit] of Object.entries(edits)) {
      const scene = new THREE.Scene();
      const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, 100);
      const wall = new THREE.Mesh(new THREE.PlaneGeometry(8, 8), new THREE.MeshBasicMaterial({ color: 0x00ff00 }));
      const thing = new THREE.Mesh(new THREE.BoxGeometry(4, 4, 1), new THREE.MeshBasicMaterial({ color: 0xff0000 }));
      wall.position.z = -5;
      thing.position.z = -9;
      scene.add(wall, thing);
      const culler = await EnfiladeCuller.load({ renderer });
      culler.addScene(scene);
      culler.update(camera);
      const before = culler.isVisible(thing);
      edit(wall);
      const { pixels: differing } = await compare(renderer, scene, camera, culler, 1, () => {});
      pixels[name] = [before, culler.isVisible(thing), differing];
      culler.dispose();
    }
    return pixels;
  },
  (pixels) => {
    assert.equal(Object.keys(pixels).length, 15);
    for (const [name, found] of Object.entries(pixels)) {
      assert.deepEqual(found, [false, true, 0], name);
    }
  },
);

onBoth(
  'clipping planes for all, and other layers of the same camera, show what was hidden',
  async (renderer, kind) => {
    const scene = new THREE.Scene();
    const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, 100);
    const wall = new THREE.Mesh(new THREE.PlaneGeometry(8, 8), new THREE.MeshBasicMaterial({ color: 0x00ff00 }));
    const thing = new THREE.Mesh(new THREE.BoxGeometry(4, 4, 1), new THREE.MeshBasicMaterial({ color: 0xff0000 }));
    const lamp = new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), new THREE.MeshBasicMaterial({ color: 0xffffff }));
    wall.position.z = -5;
    thing.position.z = -9;
    lamp.position.set(1, 1, -12);
    thing.layers.enable(2);
    lamp.layers.set(2);
    scene.add(wall, thing, lamp);
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    culler.update(camera);
    const hidden = !culler.isVisible(thing);
    // A second picture of other layers, without an update.
    const layers = camera.layers.mask;
    camera.layers.set(2);
    const a = await shoot(renderer, scene, camera);
    culler.enabled = false;
    const b = await shoot(renderer, scene, camera);
    camera.layers.mask = layers;
    culler.enabled = true;
    const plane = new THREE.Plane(new THREE.Vector3(0, 0, -1), -7);
    if (kind === 'webgl') {
      renderer.clippingPlanes = [plane];
    } else {
      const { ClippingGroup } = await import('three/webgpu');
      const group = new ClippingGroup();
      group.clippingPlanes = [plane];
      scene.add(group);
      group.add(wall, thing);
    }
    const { pixels } = await compare(renderer, scene, camera, culler, 1, () => {});
    const shown = culler.isVisible(thing);
    // All of the wall is kept now.
    plane.constant = 20;
    plane.normal.set(0, 0, 1);
    culler.update(camera);
    const again = !culler.isVisible(thing);
    return { hidden, layers: differences(a.pixels, b.pixels).length, pixels, shown, again };
  },
  (found) => assert.deepEqual(found, { hidden: true, layers: 0, pixels: 0, shown: true, again: true }),
);

onBoth(
  'two cullers on one scene, removed objects, and wrong calls',
  async (renderer) => {
    const { scene, camera, at } = rooms(16, 300);
    at(1, 12);
    const calls = async () => (await shoot(renderer, scene, camera)).calls;
    const whole = await calls();
    const [first, second] = [await EnfiladeCuller.load({ renderer }), await EnfiladeCuller.load({ renderer })];
    first.addScene(scene);
    second.addScene(scene);
    first.update(camera);
    second.update(camera);
    const both = await calls();
    first.dispose();
    const one = await calls();
    const things = scene.children.filter(({ name }) => name === 'thing');
    const { objects } = second.stats;
    // Keys given before stay; groups are as visible as what is below them.
    const [seen, unseen] = [true, false].map((is) => things.find((thing) => second.isVisible(thing) === is));
    const groups = [seen, unseen].map((thing) => {
      const group = new THREE.Group();
      scene.add(group);
      group.add(thing);
      return group;
    });
    second.add(seen, { key: 'seen' }).addScene(scene, { key: ({ name }) => name }).update(camera);
    const keys = second.visibleKeys(camera);
    const named = [keys.has('seen'), [...keys].every((key) => typeof key === 'object' || key === 'seen'), ...groups.map((group) => second.isVisible(group))];
    second.remove(things[0]).update(camera);
    const removed = second.stats.objects;
    second.add(things[0]).update(camera);
    const again = second.stats.objects;
    const flat = new THREE.PerspectiveCamera();
    flat.projectionMatrix.makeScale(1, 0, 1);
    second.update(flat);
    const unknown = [second.stats.active, second.isVisible(things[0], flat), second.visibleKeys(flat).size === again];
    const errors = [];
    const attempts = [
      () => EnfiladeCuller.load({ render: renderer }),
      () => EnfiladeCuller.load({ renderer: {} }),
      () => EnfiladeCuller.load({ samples: 2 }),
      () => EnfiladeCuller.load({ tightness: 'tight' }),
      () => EnfiladeCuller.load({ growthPx: '2' }),
      () => second.addScene(undefined),
      () => second.add([things[0]]),
      () => second.add(things[0], { ocluder: true }),
      () => second.moved([undefined]),
      () => second.update(),
      () => second.update(scene),
    ];
    for (const attempt of attempts) {
      try {
        await attempt();
        errors.push('none');
      } catch (error) {
        errors.push(error.message.startsWith('enfilade: ') ? 'clear' : error.message);
      }
    }
    second.update(camera);
    const after = await calls();
    second.dispose();
    return { whole, both, one, named, objects, removed, again, unknown, errors, after, last: await calls(), own: Object.hasOwn(things[0], 'intersectsFrustum') };
  },
  ({ whole, both, one, named, objects, removed, again, unknown, errors, after, last, own }) => {
    assert.ok(both < 0.5 * whole, `${both} of ${whole}`);
    assert.deepEqual([one, after, last, own], [both, both, whole, false]);
    assert.deepEqual([removed, again], [objects - 1, objects]);
    assert.deepEqual(named, [true, true, true, false]);
    assert.deepEqual(unknown, [false, true, true]);
    assert.deepEqual(errors, errors.map(() => 'clear'));
  },
  { warns: true },
);

onBoth(
  'other cameras, shadows, view offsets, levels of detail and reversed depth are as without it',
  async (renderer, kind) => {
    const { scene, camera, at } = rooms(16, 500);
    const sun = scene.children.find(({ isDirectionalLight }) => isDirectionalLight);
    renderer.shadowMap.enabled = true;
    sun.castShadow = true;
    Object.assign(sun.shadow.camera, { left: -30, right: 30, top: 30, bottom: -30 });
    scene.traverse((object) => {
      object.castShadow = object.name === 'thing';
      object.receiveShadow = true;
    });
    const lod = new THREE.LOD();
    [[0, 24], [4, 12], [9, 4]].forEach(([distance, segments]) => {
      lod.addLevel(new THREE.Mesh(new THREE.SphereGeometry(0.5, segments, segments), new THREE.MeshLambertMaterial({ color: 0xff00ff })), distance);
    });
    lod.position.set(9, 1.5, 12.5);
    scene.add(lod);
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    const frames = 6;
    const move = (frame) => at(frame, frames);
    const out = {};
    out.shadows = await compare(renderer, scene, camera, culler, frames, move);
    camera.setViewOffset(800, 450, 300, 100, 400, 225);
    out.offset = await compare(renderer, scene, camera, culler, frames, move);
    camera.clearViewOffset();
    const other = new THREE.PerspectiveCamera(40, 16 / 9, 0.1, 100);
    other.position.set(9, 20, 9);
    other.lookAt(9, 0, 9);
    culler.update(camera);
    const [a, b] = [await shoot(renderer, scene, other), ((culler.enabled = false), await shoot(renderer, scene, other))];
    culler.enabled = true;
    out.other = differences(a.pixels, b.pixels).length;
    out.otherCalls = [a.calls, b.calls];
    culler.update(camera);
    culler.update(other);
    const both = [await shoot(renderer, scene, camera), await shoot(renderer, scene, other)];
    culler.enabled = false;
    const whole = [await shoot(renderer, scene, camera), await shoot(renderer, scene, other)];
    culler.enabled = true;
    out.both = both.map(({ pixels }, number) => differences(pixels, whole[number].pixels).length);
    out.bothCalls = [both, whole].map((shots) => shots.map(({ calls }) => calls));
    // A camera that is not updated while things move and come: nothing is culled for it.
    culler.update(other);
    culler.update(camera);
    const things = scene.children.filter(({ name }) => name === 'thing');
    culler.hiddenObjects(other).slice(0, 40).forEach((object) => object.position.set(9 + Math.random(), 30, 9));
    things[0].removeFromParent();
    const late = new THREE.Mesh(things[0].geometry, things[0].material);
    late.position.set(9, 15, 9);
    scene.add(late);
    culler.update(camera);
    const stale = await shoot(renderer, scene, other);
    culler.enabled = false;
    out.stale = differences(stale.pixels, (await shoot(renderer, scene, other)).pixels).length;
    culler.enabled = true;
    // The camera moved after the update: nothing is culled.
    culler.update(camera);
    camera.rotation.y += 1;
    const moved = await shoot(renderer, scene, camera);
    culler.enabled = false;
    out.movedCamera = differences(moved.pixels, (await shoot(renderer, scene, camera)).pixels).length;
    culler.dispose();
    renderer.domElement.remove();

    const reversed = await createRenderer(kind, { reversedDepthBuffer: true });
    const second = await EnfiladeCuller.load({ renderer: reversed });
    second.addScene(scene);
    // The first picture is not yet reversed.
    reversed.render(scene, camera);
    out.reversed = await compare(reversed, scene, camera, second, frames, move);
    out.isReversed = camera.reversedDepth;
    return out;
  },
  (out, kind) => {
    same(out.shadows);
    same(out.offset);
    same(out.reversed);
    assert.equal(out.other, 0);
    assert.equal(out.otherCalls[0], out.otherCalls[1]);
    assert.deepEqual(out.both, [0, 0]);
    assert.ok(out.bothCalls[0][0] < out.bothCalls[1][0], `${kind}: ${JSON.stringify(out.bothCalls)}`);
    assert.deepEqual([out.movedCamera, out.stale], [0, 0]);
    assert.ok(out.reversed.calls[1] < 0.8 * out.reversed.calls[0], `${kind}: ${out.reversed.calls}, ${out.isReversed}`);
  },
);

onBoth(
  'a parallel camera is culled like any other',
  async (renderer) => {
    const { scene } = rooms(4, 50);
    const camera = new THREE.OrthographicCamera(-8, 8, 4.5, -4.5, 0.1, 100);
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    // Elevations, turned a little: the walls hide the things behind them.
    return compare(renderer, scene, camera, culler, 6, (frame) => {
      camera.position.set(30 - frame, 4 + frame, 40);
      camera.lookAt(6, 1, 6);
    });
  },
  (result) => {
    same(result);
    assert.ok(result.calls[1] < result.calls[0], `${result.calls}`);
  },
);

onBoth(
  'a camera whose projection mirrors sees through walls that are drawn from one side',
  async (renderer) => {
    const scene = new THREE.Scene();
    const wall = new THREE.Mesh(new THREE.PlaneGeometry(40, 40), new THREE.MeshBasicMaterial());
    const thing = new THREE.Mesh(new THREE.BoxGeometry(), new THREE.MeshBasicMaterial({ color: 0xff0000 }));
    wall.position.z = -5;
    thing.position.z = -9;
    scene.add(wall, thing);
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, 100);
    const results = [];
    for (const x of [1, -1]) {
      const result = await compare(renderer, scene, camera, culler, 2, () => {
        camera.updateProjectionMatrix();
        camera.projectionMatrix.elements[0] *= x;
        camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
      });
      results.push({ ...result, isSeen: culler.isVisible(thing, camera) });
    }
    return results;
  },
  ([plain, mirrored]) => {
    same(plain);
    same(mirrored);
    assert.deepEqual([plain.isSeen, mirrored.isSeen], [false, true]);
  },
  { warns: true },
);

onBoth(
  'a mirrored instance is drawn inside out, so it hides nothing',
  async (renderer) => {
    const plane = new THREE.PlaneGeometry(40, 40);
    const material = new THREE.MeshBasicMaterial();
    const walls = {
      instanced: () => new THREE.InstancedMesh(plane, material, 1),
      batched: () => {
        const batch = new THREE.BatchedMesh(1, 100, 100, material);
        batch.addInstance(batch.addGeometry(plane));
        return batch;
      },
    };
    const matrix = new THREE.Matrix4();
    const out = {};
    for (const [what, make] of Object.entries(walls)) {
      const scene = new THREE.Scene();
      const wall = make();
      const thing = new THREE.Mesh(new THREE.BoxGeometry(), new THREE.MeshBasicMaterial({ color: 0xff0000 }));
      thing.position.z = -9;
      scene.add(wall, thing);
      const culler = await EnfiladeCuller.load({ renderer, tightness: 'faces' });
      culler.addScene(scene);
      const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, 100);
      out[what] = [];
      for (const [instance, object] of [[1, 1], [-1, 1], [1, -1], [-1, -1]]) {
        const result = await compare(renderer, scene, camera, culler, 2, () => {
          wall.setMatrixAt(0, matrix.makeScale(instance, 1, 1).setPosition(0, 0, -5));
          wall.instanceMatrix && (wall.instanceMatrix.needsUpdate = true);
          wall.scale.x = object;
        });
        out[what].push({ ...result, isSeen: culler.isVisible(thing, camera) });
      }
      culler.dispose();
    }
    return out;
  },
  (out, kind) => {
    for (const [what, results] of Object.entries(out)) {
      results.forEach(same);
      assert.deepEqual(results.map(({ isSeen }) => isSeen), [false, true, false, true], `${what} on ${kind}`);
    }
  },
);

onBoth(
  'ten thousand objects move each frame; reported ones cost less; a disposed culler undoes everything',
  async (renderer) => {
    const { scene, camera, at } = rooms(16, 10_000);
    const things = scene.children.filter(({ name }) => name === 'thing');
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    const wander = (frame) => {
      at(frame, 6);
      things.forEach((thing, number) => thing.position.setX(thing.position.x + 0.01 * Math.sin(number + frame)));
    };
    const moving = await compare(renderer, scene, camera, culler, 6, wander);
    culler.autoUpdate = false;
    const reported = await compare(renderer, scene, camera, culler, 6, (frame) => {
      at(frame, 6);
      const some = things.slice(100 * frame, 100 * frame + 100);
      some.forEach((thing) => thing.position.setY(1.5));
      culler.moved(some);
    });
    culler.frozen = true;
    const before = [...culler.visibleKeys(camera)].length;
    at(5, 6);
    culler.update(camera);
    const after = [...culler.visibleKeys(camera)].length;
    culler.dispose();
    culler.dispose();
    culler.update(camera);
    const own = scene.children.filter((object) => Object.hasOwn(object, 'intersectsFrustum')).length;
    return { moving, reported, frozen: before === after, own };
  },
  ({ moving, reported, frozen, own }) => {
    same(moving);
    same(reported);
    assert.equal(moving.stats.moved > 9_000, true, JSON.stringify(moving.stats));
    assert.ok(reported.syncMs < moving.syncMs, `${reported.syncMs} and ${moving.syncMs} ms`);
    assert.deepEqual([frozen, own], [true, 0]);
  },
  // Updated once it was disposed.
  { warns: true },
);

test('a lost context changes nothing', { timeout: 60_000 }, async () => {
  const { page } = await browser.open('tests/page.html');
  await page.waitForFunction('window.ready');
  const result = await page.evaluate(async () => {
    const renderer = await createRenderer('webgl');
    const { scene, camera, at } = rooms(16, 500);
    const culler = await EnfiladeCuller.load({ renderer });
    culler.addScene(scene);
    const first = await compare(renderer, scene, camera, culler, 3, (frame) => at(frame, 6));
    renderer.forceContextLoss();
    await new Promise((resolve) => setTimeout(resolve, 100));
    at(3, 6);
    culler.update(camera);
    renderer.render(scene, camera);
    renderer.forceContextRestore();
    await new Promise((resolve) => setTimeout(resolve, 200));
    const second = await compare(renderer, scene, camera, culler, 3, (frame) => at(frame + 3, 6));
    return [first, second];
  });
  result.forEach(same);
  assert.ok(result[1].calls[1] < result[1].calls[0]);
  await page.close();
});

test('the module works in a worker', { timeout: 60_000 }, async () => {
  const { page, errors } = await browser.open('tests/page.html');
  const visible = await page.evaluate(async () => {
    const source = `
      import { load, Scene, Viewer } from '${location.origin}/dist/index.js';
      await load();
      const scene = new Scene();
      const mesh = scene.addBox([-1, -1, -1], [1, 1, 1]);
      scene.add([0, 1], [mesh, mesh], new Float32Array([1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,-9,1, 1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,9,1]));
      const viewer = new Viewer();
      viewer.look(scene, [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], [1,0,0,0, 0,1,0,0, 0,0,-1.002,-1, 0,0,-0.2002,0], { width: 64, height: 64 });
      postMessage([...viewer.visible]);`;
    const worker = new Worker(URL.createObjectURL(new Blob([source], { type: 'text/javascript' })), { type: 'module' });
    return new Promise((resolve, reject) => {
      worker.onmessage = ({ data }) => resolve(data);
      worker.onerror = (event) => reject(new Error(event.message));
    });
  });
  assert.deepEqual([visible, errors], [[0], []]);
  await page.close();
});
