// A palace, a city, and a hall of shelves to walk in.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { daylight, stage } from './stage.js';

const name = new URLSearchParams(location.search).get('scene') ?? 'palace';
const select = document.querySelector('#scene');
select.value = name;
select.addEventListener('change', () => location.assign(`?scene=${select.value}`));

const scene = new THREE.Scene();

/** Random numbers, the same each time. */
let state = 1;
const roll = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;

const scenes = {
  async palace() {
    const { scene: palace, cameras } = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync('palace.glb');
    // Portals and the like describe the palace; they are not seen.
    palace.traverse((object) => {
      object.visible &&= object.userData.enfilade === undefined || object.userData.enfilade.kind === 'room';
    });
    scene.add(palace);
    palace.updateMatrixWorld();
    const [camera] = cameras;
    const eye = camera.getWorldPosition(new THREE.Vector3());
    const toward = camera.getWorldDirection(new THREE.Vector3()).add(eye);
    return { eye: eye.toArray(), toward: toward.toArray() };
  },
  async city() {
    const ground = new THREE.Mesh(new THREE.PlaneGeometry(1200, 1200).rotateX(-Math.PI / 2), new THREE.MeshLambertMaterial({ color: 0x6d7480 }));
    scene.add(ground);
    const house = new THREE.BoxGeometry(1, 1, 1).translate(0, 0.5, 0);
    const tree = new THREE.IcosahedronGeometry(1.6, 1).translate(0, 3, 0);
    const walls = Array.from({ length: 12 }, () => new THREE.MeshLambertMaterial({ color: new THREE.Color().setHSL(0.06 + 0.08 * roll(), 0.25, 0.45 + 0.3 * roll()) }));
    const leaves = new THREE.MeshLambertMaterial({ color: 0x4c7a45 });
    for (let x = -24; x <= 24; x++) {
      for (let z = -24; z <= 24; z++) {
        for (const [dx, dz] of [[-5, -5], [5, -5], [-5, 5], [5, 5]]) {
          const mesh = new THREE.Mesh(house, walls[Math.floor(12 * roll())]);
          mesh.position.set(24 * x + dx, 0, 24 * z + dz);
          mesh.scale.set(8 + 2 * roll(), 8 + 24 * roll() ** 3, 8 + 2 * roll());
          scene.add(mesh);
        }
        const green = new THREE.Mesh(tree, leaves);
        green.position.set(24 * x + 12, 0, 24 * z + 12 * roll());
        scene.add(green);
      }
    }
    return { eye: [12, 1.7, 12], toward: [12, 3, -80], speed: 12 };
  },
  async hall() {
    const wood = new THREE.MeshLambertMaterial({ color: 0x8a6a48 });
    const unit = new THREE.BoxGeometry(1, 1, 1);
    const [rows, length] = [24, 70];
    const board = (x, y, z, w, h, d) => {
      const mesh = new THREE.Mesh(unit, wood);
      mesh.position.set(x, y, z);
      mesh.scale.set(w, h, d);
      scene.add(mesh);
    };
    board(length / 2, -0.1, 1.5 * rows, length + 8, 0.2, 3 * rows + 8);
    for (let row = 0; row < rows; row++) {
      board(length / 2, 1.6, 3 * row, length, 3.2, 0.1);
      for (let shelf = 0; shelf < 4; shelf++) {
        board(length / 2, 0.2 + 0.8 * shelf, 3 * row, length, 0.06, 0.8);
      }
    }
    const shapes = [new THREE.BoxGeometry(0.3, 0.4, 0.25), new THREE.SphereGeometry(0.2, 20, 14), new THREE.ConeGeometry(0.2, 0.45, 20), new THREE.TorusKnotGeometry(0.12, 0.05, 64, 8)];
    const matrix = new THREE.Matrix4();
    for (const shape of shapes) {
      const many = new THREE.InstancedMesh(shape, new THREE.MeshLambertMaterial(), 2500);
      for (let number = 0; number < many.count; number++) {
        const side = roll() < 0.5 ? 0.22 : -0.22;
        many.setMatrixAt(number, matrix.makeTranslation(length * roll(), 0.46 + 0.8 * Math.floor(4 * roll()), 3 * Math.floor(rows * roll()) + side));
        many.setColorAt(number, new THREE.Color().setHSL(roll(), 0.55, 0.55));
      }
      scene.add(many);
    }
    return { eye: [1, 1.7, 34.5], toward: [30, 1.5, 34.5] };
  },
};

const view = await (scenes[name] ?? scenes.palace)();
// Unless the file has its own.
if (!scene.getObjectsByProperty('isLight', true).length) {
  daylight(scene);
}
Object.assign(window, await stage(scene, view), { scene });
