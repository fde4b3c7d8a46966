// What the pages share: a renderer, a camera to walk with, and a culler with its overlay.
import * as THREE from 'three';
import { CullerOverlay, EnfiladeCuller } from 'enfilade/three';

/** Creates all that is needed to show a scene. `each(seconds)` is called before each frame. */
export async function stage(scene, { eye, toward, far = 2000, speed = 4, each = () => {} }) {
  const renderer = new THREE.WebGLRenderer({ antialias: true });
  renderer.setPixelRatio(devicePixelRatio);
  document.body.prepend(renderer.domElement);
  const camera = new THREE.PerspectiveCamera(65, 1, 0.1, far);
  camera.rotation.order = 'YXZ';
  camera.position.set(...eye);
  camera.lookAt(...toward);
  const resize = () => {
    camera.aspect = innerWidth / innerHeight;
    camera.updateProjectionMatrix();
    renderer.setSize(innerWidth, innerHeight);
  };
  addEventListener('resize', resize);
  resize();

  const culler = await EnfiladeCuller.load({ renderer, wasm: 'core_bg.wasm' });
  culler.addScene(scene);
  const overlay = new CullerOverlay(culler, scene);
  document.body.append(overlay.element);

  const walk = walking(camera, renderer.domElement, speed);
  const counts = document.querySelector('#counts');
  const timer = new THREE.Timer();
  renderer.setAnimationLoop((time) => {
    timer.update(time);
    const seconds = Math.min(timer.getDelta(), 0.1);
    walk(seconds);
    each(seconds);
    culler.update(camera);
    renderer.render(scene, camera);
    overlay.update(camera);
    const { calls, triangles } = renderer.info.render;
    counts.textContent = `draw calls ${calls.toLocaleString('en')}\ntriangles  ${triangles.toLocaleString('en')}`;
    document.body.dataset.calls = String(calls);
  });
  return { renderer, camera, culler };
}

/** Drag and keys move a camera. Returns what to call each frame. */
function walking(camera, canvas, speed) {
  const keys = new Set();
  addEventListener('keydown', ({ code }) => keys.add(code));
  addEventListener('keyup', ({ code }) => keys.delete(code));
  addEventListener('blur', () => keys.clear());
  canvas.addEventListener('pointermove', ({ buttons, movementX, movementY }) => {
    if (buttons & 1) {
      camera.rotation.y += 0.003 * movementX;
      camera.rotation.x = Math.max(-1.5, Math.min(1.5, camera.rotation.x + 0.003 * movementY));
    }
  });
  const step = new THREE.Vector3();
  const along = (plus, minus) => Number(keys.has(plus)) - Number(keys.has(minus));
  return (seconds) => {
    step.set(along('KeyD', 'KeyA'), along('KeyE', 'KeyQ'), along('KeyS', 'KeyW'));
    step.multiplyScalar(seconds * speed * (keys.has('ShiftLeft') ? 4 : 1)).applyEuler(camera.rotation);
    camera.position.add(step);
  };
}

/** Light for scenes without any. */
export function daylight(scene, sky = 0x9ec4e8) {
  scene.background = new THREE.Color(sky);
  const sun = new THREE.DirectionalLight(0xfff2dd, 2.2);
  sun.position.set(0.4, 1, 0.6);
  scene.add(sun, new THREE.HemisphereLight(0xe8f0ff, 0xa89a88, 1.6));
}
