import { Box3, BufferAttribute, BufferGeometry, CameraHelper, LineBasicMaterial, LineSegments, type Camera, type Object3D } from 'three';
import type { EnfiladeCuller } from './culler.js';

const edges = [0, 1, 1, 3, 3, 2, 2, 0, 4, 5, 5, 7, 7, 6, 6, 4, 0, 4, 1, 5, 2, 6, 3, 7];

/**
 * A panel with counts and switches, for development, and boxes around what is skipped while the culler is frozen.
 *
 * Call `update` once per frame, after the culler's.
 */
export class CullerOverlay {
  readonly element = document.createElement('div');
  readonly #culler: EnfiladeCuller;
  readonly #counts = document.createElement('pre');
  readonly #scene: Object3D | undefined;
  #boxes: LineSegments | undefined;
  #helper: CameraHelper | undefined;

  /** @param scene where boxes are drawn while the culler is frozen; without it there are none */
  constructor(culler: EnfiladeCuller, scene?: Object3D) {
    this.#culler = culler;
    this.#scene = scene;
    this.element.style.cssText =
      'position:fixed;right:12px;top:12px;padding:10px 12px;background:#111c;color:#eee;font:12px/1.5 ui-monospace,monospace;border-radius:6px;z-index:10';
    this.#counts.style.cssText = 'margin:0 0 6px;font:inherit';
    this.element.append(
      this.#counts,
      toggle('cull', true, (on) => (culler.enabled = on)),
      toggle('freeze', false, (on) => (culler.frozen = on)),
    );
  }

  /** Shows what the last update of the culler did for a camera. */
  update(camera: Camera): void {
    const { objects, visible, hidden, moved, unculled, syncMs, lookMs } = this.#culler.stats;
    const row = (name: string, value: string | number) => `${name.padEnd(9)}${String(value).padStart(9)}`;
    const ms = (time: number) => `${time.toFixed(2)} ms`;
    this.#counts.textContent = [
      row('objects', objects),
      row('visible', visible),
      row('hidden', hidden),
      row('moved', moved),
      row('unculled', unculled),
      row('sync', ms(syncMs)),
      row('look', ms(lookMs)),
    ].join('\n');
    if (this.#culler.frozen && this.#scene && !this.#boxes) {
      this.#boxes = boxesOf(this.#culler.hiddenObjects(camera));
      const frozen = camera.clone();
      frozen.matrixAutoUpdate = false;
      this.#helper = new CameraHelper(frozen);
      this.#scene.add(this.#boxes, this.#helper);
    } else if (!this.#culler.frozen && this.#boxes) {
      this.#clear();
    }
  }

  dispose(): void {
    this.#clear();
    this.element.remove();
  }

  #clear(): void {
    this.#boxes?.removeFromParent();
    this.#boxes?.geometry.dispose();
    this.#helper?.removeFromParent();
    this.#helper?.dispose();
    this.#boxes = undefined;
    this.#helper = undefined;
  }
}

function toggle(name: string, initially: boolean, change: (on: boolean) => void): HTMLElement {
  const label = document.createElement('label');
  const box = document.createElement('input');
  box.type = 'checkbox';
  box.checked = initially;
  box.addEventListener('change', () => change(box.checked));
  label.append(box, ` ${name}  `);
  label.style.marginRight = '12px';
  return label;
}

function boxesOf(objects: Object3D[]): LineSegments {
  const corners: number[] = [];
  const indices: number[] = [];
  const bounds = new Box3();
  for (const object of objects) {
    const first = corners.length / 3;
    const { min, max } = bounds.setFromObject(object);
    for (let corner = 0; corner < 8; corner++) {
      corners.push(corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z);
    }
    indices.push(...edges.map((edge) => first + edge));
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(corners), 3));
  geometry.setIndex(indices);
  return new LineSegments(geometry, new LineBasicMaterial({ color: 0xff5533, depthTest: false, transparent: true }));
}
