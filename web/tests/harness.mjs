// What the tests do inside the page.
import * as THREE from 'three';
import { EnfiladeCuller } from 'enfilade/three';

export { THREE, EnfiladeCuller };

/** Creates a renderer: 'webgl', or 'webgpu' with its WebGL2 backend. */
export async function createRenderer(kind, { width = 400, height = 225, antialias = false, ...options } = {}) {
  let renderer;
  if (kind === 'webgl') {
    renderer = new THREE.WebGLRenderer({ antialias, preserveDrawingBuffer: true, ...options });
  } else {
    const { WebGPURenderer } = await import('three/webgpu');
    renderer = new WebGPURenderer({ antialias, forceWebGL: true, ...options });
    await renderer.init();
  }
  renderer.isAntialiased = antialias;
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  renderer.info.autoReset = false;
  document.body.append(renderer.domElement);
  return renderer;
}

/** Renders, and returns the pixels and what was drawn. */
export async function shoot(renderer, scene, camera) {
  renderer.info.reset();
  const { width, height } = renderer.domElement;
  const start = performance.now();
  const pixels = new Uint8Array(4 * width * height);
  const gl = renderer.getContext?.() ?? renderer.backend.gl;
  renderer.render(scene, camera);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const { render } = renderer.info;
  return { pixels, calls: render.drawCalls ?? render.calls, triangles: render.triangles, ms: performance.now() - start };
}

/** Returns the pixels in which two pictures differ. */
export function differences(a, b) {
  const [x, y] = [new Uint32Array(a.buffer), new Uint32Array(b.buffer)];
  const pixels = [];
  for (let pixel = 0; pixel < x.length; pixel++) {
    if (x[pixel] !== y[pixel]) {
      pixels.push(pixel);
    }
  }
  return pixels;
}

/** Where a picture is sampled, in 1/16 pixel from the corner: at the centre, or by the usual positions of four samples. */
const positions = (antialias) => (antialias ? [[6, 2], [14, 6], [2, 10], [10, 14]] : [[8, 8]]);

/**
 * Returns the first of some pixels that, by ray casting, shows an object that is said to be hidden: a false cull. Pictures
 * may differ a little without one. Rasterizers move vertices (this one to multiples of 1/16 pixel), which opens and closes
 * gaps, and gives triangles that are thinner than that a depth far from their own.
 */
export function falseCull(pixels, renderer, scene, camera, culler) {
  const { width, height } = renderer.domElement;
  const ray = new THREE.Raycaster();
  ray.near = camera.near;
  ray.layers.mask = camera.layers.mask;
  for (const pixel of pixels) {
    for (const [dx, dy] of positions(renderer.isAntialiased)) {
      const x = (pixel % width) + dx / 16;
      const y = Math.floor(pixel / width) + dy / 16;
      ray.setFromCamera(new THREE.Vector2((2 * x) / width - 1, (2 * y) / height - 1), camera);
      const hits = ray.intersectObjects(scene.children, true);
      const first = hits.find(({ object }) => !object.isLine && isShown(object));
      if (first && !culler.isVisible(first.object, camera, first.instanceId ?? first.batchId)) {
        return { x, y, object: first.object.name, distance: first.distance };
      }
    }
  }
  return undefined;
}

function isShown(object) {
  for (let above = object; above; above = above.parent) {
    if (!above.visible) {
      return false;
    }
  }
  return true;
}

/** Draws each frame of a path with and without the culler, and compares. `at` moves the camera, and what else moves. */
export async function compare(renderer, scene, camera, culler, frames, at) {
  const total = { frames, size: renderer.domElement.width * renderer.domElement.height, differing: 0, pixels: 0, calls: [0, 0], triangles: [0, 0], ms: [0, 0], lookMs: 0, syncMs: 0, firstLookMs: 0, worst: -1, falseCulls: [] };
  let worst = 0;
  for (let frame = 0; frame < frames; frame++) {
    await at(frame);
    culler.enabled = true;
    culler.update(camera);
    const culled = await shoot(renderer, scene, camera);
    culler.enabled = false;
    const whole = await shoot(renderer, scene, camera);
    culler.enabled = true;
    const pixels = differences(culled.pixels, whole.pixels);
    total.differing += pixels.length > 0 ? 1 : 0;
    total.pixels += pixels.length;
    if (pixels.length > worst) {
      worst = pixels.length;
      total.worst = frame;
    }
    if (pixels.length > 0 && total.falseCulls.length < 8) {
      const some = pixels.filter((_, number) => number % Math.ceil(pixels.length / 32) === 0);
      const found = falseCull(some, renderer, scene, camera, culler);
      if (found) {
        total.falseCulls.push({ frame, ...found });
      }
    }
    [whole, culled].forEach((shot, number) => {
      total.calls[number] += shot.calls / frames;
      total.triangles[number] += shot.triangles / frames;
      total.ms[number] += shot.ms / frames;
    });
    if (frame === 0) {
      total.firstLookMs = culler.stats.lookMs;
    } else {
      total.lookMs += culler.stats.lookMs / (frames - 1);
      total.syncMs += culler.stats.syncMs / (frames - 1);
    }
  }
  return { ...total, stats: { ...culler.stats } };
}

/** A random number generator: the same numbers every time. */
export function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

/** Rooms in a grid, with a door between neighbours and furniture in each. */
export function rooms(count, things) {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x88aaff);
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(1, 3, 2);
  scene.add(sun, new THREE.AmbientLight(0xffffff, 0.6));
  const roll = random(1);
  const unit = new THREE.BoxGeometry(1, 1, 1);
  const ball = new THREE.SphereGeometry(0.5, 12, 8);
  const materials = [0xcc4444, 0x44cc66, 0x4466cc, 0xccaa44, 0xaa66cc].map((color) => new THREE.MeshLambertMaterial({ color }));
  const plaster = new THREE.MeshLambertMaterial({ color: 0xddd8d0 });
  const box = (x, y, z, w, h, d, material) => {
    const mesh = new THREE.Mesh(unit, material);
    mesh.position.set(x, y, z);
    mesh.scale.set(w, h, d);
    scene.add(mesh);
    return mesh;
  };
  const side = Math.ceil(Math.sqrt(count));
  const size = 6;
  for (let row = 0; row < side; row++) {
    for (let column = 0; column < side; column++) {
      const [x, z] = [column * size, row * size];
      box(x, -0.1, z, size, 0.2, size, plaster);
      box(x, 3.1, z, size, 0.2, size, plaster);
      for (const [dx, dz, along] of [[size / 2, 0, 'z'], [0, size / 2, 'x'], ...(column ? [] : [[-size / 2, 0, 'z']]), ...(row ? [] : [[0, -size / 2, 'x']])]) {
        for (const end of [-1.8, 1.8]) {
          const wall = along === 'z' ? box(x + dx, 1.5, z + end, 0.2, 3, 2.4, plaster) : box(x + end, 1.5, z + dz, 2.4, 3, 0.2, plaster);
          wall.name = 'wall';
        }
        if (along === 'z') {
          box(x + dx, 2.6, z, 0.2, 0.8, 1.2, plaster);
        } else {
          box(x, 2.6, z + dz, 1.2, 0.8, 0.2, plaster);
        }
      }
    }
  }
  for (let number = 0; number < things; number++) {
    const [column, row] = [Math.floor(roll() * side), Math.floor(roll() * side)];
    const mesh = new THREE.Mesh(roll() < 0.5 ? unit : ball, materials[Math.floor(roll() * materials.length)]);
    mesh.position.set(column * size + (roll() - 0.5) * 5, 0.2 + roll() * 1.2, row * size + (roll() - 0.5) * 5);
    mesh.scale.setScalar(0.1 + 0.3 * roll());
    mesh.rotation.set(roll() * 3, roll() * 3, roll() * 3);
    mesh.name = 'thing';
    scene.add(mesh);
  }
  const camera = new THREE.PerspectiveCamera(70, 16 / 9, 0.05, 200);
  /** Walks through the doors of a row of rooms, looking about. */
  const at = (frame, frames = 60) => {
    const t = frame / frames;
    camera.position.set(t * (side - 1) * size, 1.6, size * Math.floor(side / 2));
    camera.rotation.set(0, Math.sin(t * 9) * 2.5 - Math.PI / 2, 0, 'YXZ');
  };
  return { scene, camera, at };
}

/** Loads a `.glb` with a light, and a camera that goes from stop to stop: each `eye` and `toward`, six numbers. */
export async function world(path, stops) {
  const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
  const loader = new GLTFLoader();
  const { scene: loaded } = await loader.loadAsync(path);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x88aaff);
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(1, 3, 2);
  scene.add(loaded, sun, new THREE.AmbientLight(0xffffff, 0.6));
  loaded.traverse((object) => {
    if (object.isMesh && !object.geometry.attributes.normal) {
      object.material = Object.assign(object.material.clone(), { flatShading: true });
    }
  });
  const bounds = new THREE.Box3().setFromObject(loaded);
  const camera = new THREE.PerspectiveCamera(60, 16 / 9, 0.1, bounds.getSize(new THREE.Vector3()).length());
  const toward = new THREE.Vector3();
  const at = (frame, frames = 60) => {
    const t = (frame / frames) * (stops.length - 1);
    const [from, to, part] = [stops[Math.floor(t)], stops[Math.floor(t) + 1], t % 1];
    const mix = from.map((value, number) => value + (to[number] - value) * part);
    camera.position.set(...mix.slice(0, 3));
    camera.lookAt(toward.set(...mix.slice(3)));
  };
  return { scene, camera, at };
}

/** A hall of shelves, with instances of a few meshes on them. */
export function hall(count) {
  const { scene, camera, at } = rooms(1, 0);
  scene.children.filter(({ isMesh }) => isMesh).forEach((mesh) => mesh.removeFromParent());
  const roll = random(5);
  const wood = new THREE.MeshLambertMaterial({ color: 0x886644 });
  const unit = new THREE.BoxGeometry(1, 1, 1);
  const box = (x, y, z, w, h, d) => {
    const mesh = new THREE.Mesh(unit, wood);
    mesh.position.set(x, y, z);
    mesh.scale.set(w, h, d);
    scene.add(mesh);
  };
  const [rows, length] = [20, 60];
  box(length / 2, -0.1, (3 * rows) / 2, length + 6, 0.2, 3 * rows + 6);
  for (let row = 0; row < rows; row++) {
    box(length / 2, 1.5, 3 * row, length, 3, 0.1);
    for (let board = 0; board < 4; board++) {
      box(length / 2, 0.2 + 0.8 * board, 3 * row, length, 0.06, 0.8);
    }
  }
  const shapes = [new THREE.BoxGeometry(0.3, 0.4, 0.25), new THREE.SphereGeometry(0.2, 16, 12), new THREE.ConeGeometry(0.2, 0.45, 16), new THREE.TorusKnotGeometry(0.12, 0.05, 48, 8)];
  const matrix = new THREE.Matrix4();
  const color = new THREE.Color();
  for (const shape of shapes) {
    const many = new THREE.InstancedMesh(shape, new THREE.MeshLambertMaterial(), count / shapes.length);
    for (let number = 0; number < many.count; number++) {
      const side = roll() < 0.5 ? 0.22 : -0.22;
      matrix.makeTranslation(length * roll(), 0.48 + 0.8 * Math.floor(4 * roll()), 3 * Math.floor(rows * roll()) + side);
      many.setMatrixAt(number, matrix);
      many.setColorAt(number, color.setHSL(roll(), 0.6, 0.5));
    }
    scene.add(many);
  }
  const walk = (frame, frames) => {
    const t = frame / frames;
    camera.position.set(length * t, 1.6, 31.5);
    camera.rotation.set(0, -Math.PI / 2 + Math.sin(7 * t), 0, 'YXZ');
  };
  return { scene, camera, at: walk };
}
