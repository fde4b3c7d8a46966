// A building as BIM viewers show it: elements with a globalId, by storeys, of which only the visible ones are drawn.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { daylight, stage } from './stage.js';

const scene = new THREE.Scene();
daylight(scene, 0xcfd8e2);

/** The name of an object in its file: three.js leaves characters out. */
const nameOf = (object) => object.userData.name ?? object.name;

/** An IFC globalId at the end of a name, as IfcConvert and others write: 22 characters of its alphabet. */
const globalIdOf = (object) => object.userData.globalId ?? object.userData.GlobalId ?? nameOf(object).match(/([0-3][0-9A-Za-z_$]{21})$/)?.[1];

/** A building of a few storeys with rooms, furniture and pipes. */
function sample() {
  const building = new THREE.Group();
  let state = 7;
  const roll = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
  const alphabet = '0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$';
  const newId = () => `${Math.floor(4 * roll())}${Array.from({ length: 21 }, () => alphabet[Math.floor(64 * roll())]).join('')}`;
  const unit = new THREE.BoxGeometry(1, 1, 1);
  const paint = (color, more) => new THREE.MeshLambertMaterial({ color, ...more });
  const materials = {
    IfcSlab: paint(0xb9b4ac),
    IfcWall: paint(0xe7e2d8),
    IfcWindow: paint(0x99c2dd, { transparent: true, opacity: 0.35 }),
    IfcFurniture: paint(0x9a6b43),
    IfcPipeSegment: paint(0x4f8f6f),
  };
  const [width, depth, size] = [10, 5, 5];
  for (let storey = 0; storey < 4; storey++) {
    const floor = new THREE.Group();
    floor.name = `Storey ${storey}`;
    floor.position.y = 3.2 * storey;
    building.add(floor);
    const add = (kind, x, y, z, w, h, d) => {
      const mesh = new THREE.Mesh(unit, materials[kind]);
      mesh.name = kind;
      mesh.userData.globalId = newId();
      mesh.position.set(x, y, z);
      mesh.scale.set(w, h, d);
      floor.add(mesh);
    };
    add('IfcSlab', (width * size) / 2, -0.1, (depth * size) / 2, width * size + 0.2, 0.2, depth * size + 0.2);
    for (let column = 0; column < width; column++) {
      for (let row = 0; row < depth; row++) {
        const [x, z] = [column * size, row * size];
        // A door at one end of each inner wall, a window in each outer one.
        if (column === 0) {
          add('IfcWall', x, 0.45, z + size / 2, 0.2, 0.9, size);
          add('IfcWall', x, 2.7, z + size / 2, 0.2, 0.6, size);
          add('IfcWindow', x, 1.65, z + size / 2, 0.05, 1.5, size);
        } else {
          add('IfcWall', x, 1.5, z + 2, 0.12, 3, 4);
        }
        if (row > 0) {
          add('IfcWall', x + 2, 1.5, z, 4, 3, 0.12);
        }
        for (let thing = 0; thing < 14; thing++) {
          const [w, d] = [0.3 + 0.8 * roll(), 0.3 + 0.8 * roll()];
          const h = 0.4 + 0.7 * roll();
          add('IfcFurniture', x + 0.8 + 3.2 * roll(), h / 2, z + 0.8 + 3.2 * roll(), w, h, d);
        }
        add('IfcPipeSegment', x + size / 2, 2.8, z + 1, size, 0.1, 0.1);
      }
    }
    for (const [x, z, w, d] of [[width * size, (depth * size) / 2, 0.2, depth * size], [(width * size) / 2, 0, width * size, 0.2], [(width * size) / 2, depth * size, width * size, 0.2]]) {
      add('IfcWall', x, 1.5, z, w, 3, d);
    }
  }
  building.add(Object.assign(new THREE.Mesh(unit, materials.IfcSlab), { name: 'IfcRoof' }));
  building.children.at(-1).position.set((width * size) / 2, 12.8, (depth * size) / 2);
  building.children.at(-1).scale.set(width * size + 1, 0.3, depth * size + 1);
  return { building, eye: [0.8, 1.7, 4.5], toward: [30, 1.4, 5.5] };
}

let building;
let shown;

function show(next) {
  building?.removeFromParent();
  building = next;
  scene.add(building);
  list();
}

const meshesBelow = (objects) => {
  const meshes = [];
  objects.forEach((object) => object.traverse((below) => below.isMesh && meshes.push(below)));
  return meshes;
};

/** Returns the storeys of a building by name, if its file has them; else its elements by their kind. */
function partsOf(object) {
  let level = object.children;
  while (level.length === 1 && level[0].children.length > 0) {
    level = level[0].children;
  }
  const storeys = level.filter((part) => meshesBelow([part]).length > 20);
  const parts = new Map();
  const add = (name, part) => parts.set(name, [...(parts.get(name) ?? []), part]);
  level.forEach((part) => add(storeys.length > 1 ? nameOf(part) : nameOf(part).split(':')[0], part));
  return [...parts].sort(([a], [b]) => a.localeCompare(b));
}

function list() {
  shown = partsOf(building).map(([label, objects]) => {
    const row = document.createElement('li');
    const [name, count] = [document.createElement('span'), document.createElement('span')];
    name.textContent = label || 'unnamed';
    row.append(name, count);
    row.addEventListener('click', () => {
      const visible = !objects[0].visible;
      objects.forEach((object) => (object.visible = visible));
      row.style.opacity = visible ? '' : '0.4';
    });
    return { row, count, meshes: meshesBelow(objects) };
  });
  document.querySelector('#storeys').replaceChildren(...shown.map(({ row }) => row));
}

const { building: first, eye, toward } = sample();
show(first);
let frame = 0;
const { camera, culler, renderer } = await stage(scene, {
  eye,
  toward,
  each() {
    if (frame++ % 10 === 1) {
      shown.forEach(({ count, meshes }) => {
        count.textContent = `${meshes.filter((mesh) => culler.isVisible(mesh)).length} of ${meshes.length} visible`;
      });
    }
  },
});

const element = document.querySelector('#element');
const ray = new THREE.Raycaster();
let selected;
let down;
renderer.domElement.addEventListener('pointerdown', ({ clientX, clientY }) => (down = [clientX, clientY]));
renderer.domElement.addEventListener('pointerup', ({ clientX, clientY }) => {
  if (Math.hypot(clientX - down[0], clientY - down[1]) > 4) {
    return;
  }
  ray.setFromCamera(new THREE.Vector2((2 * clientX) / innerWidth - 1, 1 - (2 * clientY) / innerHeight), camera);
  const hit = ray.intersectObject(building).find(({ object }) => culler.isVisible(object));
  if (selected) {
    selected.mesh.material = selected.material;
  }
  selected = hit && { mesh: hit.object, material: hit.object.material };
  if (!hit) {
    element.textContent = 'nothing selected';
    return;
  }
  hit.object.material = Object.assign(hit.object.material.clone(), { emissive: new THREE.Color(0xaa5500) });
  let named = hit.object;
  while (named.parent && !globalIdOf(named)) {
    named = named.parent;
  }
  element.textContent = `${nameOf(named)}\nglobalId ${globalIdOf(named) ?? 'none'}\n${hit.distance.toFixed(2)} m away`;
});

addEventListener('dragover', (event) => event.preventDefault());
addEventListener('drop', async (event) => {
  event.preventDefault();
  const [file] = event.dataTransfer.files;
  if (file) {
    await open(URL.createObjectURL(file));
  }
});

async function open(address) {
  try {
    const { scene: loaded } = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync(address);
    loaded.traverse((object) => {
      if (object.isMesh && !object.geometry.attributes.normal) {
        object.material = Object.assign(object.material.clone(), { flatShading: true });
      }
    });
    show(loaded);
    const box = new THREE.Box3().setFromObject(loaded);
    camera.position.copy(box.getCenter(new THREE.Vector3())).setY(box.min.y + 1.7);
  } catch (why) {
    element.textContent = `this file cannot be shown: ${why.message}`;
  }
}

const file = new URLSearchParams(location.search).get('file');
if (file) {
  await open(file);
}
Object.assign(window, { camera, culler, renderer, scene });
