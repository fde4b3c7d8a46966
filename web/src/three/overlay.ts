import { Box3, BufferAttribute, BufferGeometry, CameraHelper, Frustum, LineBasicMaterial, LineSegments, Matrix4, type Camera, type Object3D } from 'three';
import type { EnfiladeCuller } from './culler.js';

const edges = [0, 1, 1, 3, 3, 2, 2, 0, 4, 5, 5, 7, 7, 6, 6, 4, 0, 4, 1, 5, 2, 6, 3, 7];

const meanings: Record<string, string> = {
  objects: 'objects and instances that were looked for',
  visible: 'those that may be visible, and are drawn',
  hidden: 'those that are skipped: outside the frustum, or behind others',
  moved: 'those that moved since the update before',
  unculled: 'meshes that are left to the frustum test of three.js',
  compare: 'time to find out what moved or changed',
  look: 'time to find out what is visible',
};

/**
 * A panel with counts and switches, for development; while the culler is frozen, also the frustum that it is frozen for, and
 * orange boxes around the objects in it that are skipped.
 *
 * Call `update` once per frame, after the culler's. Place `element` where you like.
 */
export class CullerOverlay {
  readonly element = document.createElement('div');
  readonly #culler: EnfiladeCuller;
  readonly #scene: Object3D | undefined;
  readonly #counts = document.createElement('table');
  readonly #cells = new Map<string, HTMLElement>();
  readonly #note = document.createElement('div');
  readonly #cull: HTMLInputElement;
  readonly #freeze: HTMLInputElement;
  #boxes: LineSegments | undefined;
  #helper: CameraHelper | undefined;
  /** The camera at the last update that looked. */
  #looked: Camera | undefined;

  /** @param scene where boxes are drawn while the culler is frozen; without it there are none */
  constructor(culler: EnfiladeCuller, scene?: Object3D) {
    this.#culler = culler;
    this.#scene = scene;
    this.element.style.cssText =
      'position:fixed;right:12px;top:12px;padding:10px 12px;background:#111c;color:#eee;font:12px/1.5 ui-monospace,monospace;border-radius:6px;z-index:10';
    const title = document.createElement('div');
    title.textContent = 'Enfilade';
    title.style.cssText = 'font-weight:bold;margin-bottom:4px';
    this.#counts.style.cssText = 'border-spacing:0;width:100%';
    for (const [name, meaning] of Object.entries(meanings)) {
      const row = this.#counts.insertRow();
      row.title = meaning;
      row.insertCell().textContent = name;
      const cell = row.insertCell();
      cell.style.cssText = 'text-align:right;padding-left:24px;white-space:nowrap';
      this.#cells.set(name, cell);
    }
    this.#cull = toggle((on) => (culler.enabled = on));
    this.#freeze = toggle((on) => (culler.frozen = on));
    const switches = document.createElement('div');
    switches.style.cssText = 'display:flex;gap:16px;margin-top:6px';
    switches.append(labelled(this.#cull, 'cull'), labelled(this.#freeze, 'freeze'));
    this.element.append(title, this.#counts, this.#note, switches);
  }

  /** Shows what the last update of the culler did for a camera. */
  update(camera: Camera): void {
    const { enabled, frozen, stats } = this.#culler;
    const { active, objects, visible, hidden, moved, unculled, syncMs, lookMs } = stats;
    const counts = { objects, visible, hidden, moved, unculled };
    for (const [name, count] of Object.entries(counts)) {
      this.#cells.get(name)!.textContent = count.toLocaleString('en');
    }
    this.#cells.get('compare')!.textContent = frozen ? '–' : `${syncMs.toFixed(2)} ms`;
    this.#cells.get('look')!.textContent = frozen ? '–' : `${lookMs.toFixed(2)} ms`;
    this.#counts.style.opacity = enabled && active ? '' : '0.4';
    this.#note.textContent = !enabled ? 'culling is off' : frozen ? 'frozen: orange is skipped' : active ? '' : 'nothing is culled';
    this.#cull.checked = enabled;
    this.#freeze.checked = frozen;
    if (!frozen) {
      this.#clear();
      this.#looked = camera.clone();
    } else if (this.#scene && !this.#boxes && this.#looked) {
      const looked = this.#looked;
      looked.matrixAutoUpdate = false;
      this.#boxes = boxesOf(this.#culler.hiddenObjects(camera), looked);
      this.#helper = new CameraHelper(looked);
      this.#boxes.raycast = () => {};
      this.#helper.raycast = () => {};
      this.#scene.add(this.#boxes, this.#helper);
    }
  }

  dispose(): void {
    this.#clear();
    this.element.remove();
  }

  #clear(): void {
    if (this.#boxes && this.#helper) {
      this.#boxes.removeFromParent();
      this.#boxes.geometry.dispose();
      (this.#boxes.material as LineBasicMaterial).dispose();
      this.#helper.removeFromParent();
      this.#helper.dispose();
    }
    this.#boxes = undefined;
    this.#helper = undefined;
  }
}

function toggle(change: (on: boolean) => void): HTMLInputElement {
  const box = document.createElement('input');
  box.type = 'checkbox';
  box.style.cssText = 'margin:0';
  box.addEventListener('change', () => change(box.checked));
  return box;
}

function labelled(box: HTMLInputElement, name: string): HTMLElement {
  const label = document.createElement('label');
  label.style.cssText = 'display:flex;align-items:center;gap:6px;cursor:pointer';
  label.append(box, name);
  return label;
}

/** Returns the boxes of those objects that are in the frustum of a camera. */
function boxesOf(objects: Object3D[], camera: Camera): LineSegments {
  const matrix = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const frustum = new Frustum().setFromProjectionMatrix(matrix, camera.coordinateSystem, camera.reversedDepth);
  const corners: number[] = [];
  const indices: number[] = [];
  const bounds = new Box3();
  for (const object of objects) {
    const { min, max } = bounds.setFromObject(object);
    if (!frustum.intersectsBox(bounds)) {
      continue;
    }
    const first = corners.length / 3;
    for (let corner = 0; corner < 8; corner++) {
      corners.push(corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z);
    }
    indices.push(...edges.map((edge) => first + edge));
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(corners), 3));
  geometry.setIndex(indices);
  return new LineSegments(geometry, new LineBasicMaterial({ color: 0xff7733, depthTest: false, transparent: true, opacity: 0.6 }));
}
