import { Frustum, type Camera, Matrix4 } from 'three';
import { Viewer, type ViewerOptions } from '../index.js';
import type { Slots } from './slots.js';

/** A camera, and what it saw when it was looked from last. */
export class CameraView {
  readonly camera: Camera;
  readonly viewer: Viewer;
  /** Bits of the slots that are visible, and of those that it was decided for. Copies: the module's memory may move. */
  #visible = new Uint32Array(0);
  #present = new Uint32Array(0);
  /** The six planes of the frustum: 24 numbers. */
  readonly #planes = new Float64Array(24).fill(NaN);
  #layers = 0;
  readonly #frustum = new Frustum();
  readonly #matrix = new Matrix4();

  readonly #slots: Slots;
  /** Version of the slots that it looked at. */
  #version = -1;

  constructor(camera: Camera, slots: Slots, options: ViewerOptions) {
    this.camera = camera;
    this.#slots = slots;
    this.viewer = new Viewer(options);
  }

  /** Makes the camera's present frustum the one that is culled for. */
  aim(): void {
    const { camera } = this;
    this.#matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    this.#frustum.setFromProjectionMatrix(this.#matrix, camera.coordinateSystem, camera.reversedDepth);
    this.#frustum.planes.forEach(({ normal, constant }, number) => {
      this.#planes.set([normal.x, normal.y, normal.z, constant], 4 * number);
    });
  }

  /** Whether there was a look that still holds. */
  get isKnown(): boolean {
    return !Number.isNaN(this.#planes[0]);
  }

  /** Culls nothing until the next look. */
  forget(): void {
    this.#planes.fill(NaN);
    this.#present.fill(0);
    this.#visible.fill(0);
  }

  look(width: number, height: number): void {
    const { camera } = this;
    const slots = this.#slots;
    const depth = camera.reversedDepth ? '1..0' : camera.coordinateSystem === 2001 ? '0..1' : '-1..1';
    this.viewer.look(slots.scene, camera.matrixWorldInverse.elements, camera.projectionMatrix.elements, {
      width,
      height,
      depth,
      layers: camera.layers.mask,
    });
    if (this.viewer.isMirrored) {
      // three.js looks at the transforms of objects alone: of this camera, it draws the sides that are away from it.
      throw Object.assign(new Error('its matrices mirror, and three.js draws back faces for such cameras'), { code: 'view/mirrored' });
    }
    const { bits } = this.viewer;
    if (this.#present.length < slots.present.length) {
      this.#present = new Uint32Array(slots.present.length);
      this.#visible = new Uint32Array(slots.present.length);
    }
    slots.presentIn(camera.layers.mask, this.#present);
    this.#layers = camera.layers.mask;
    this.#version = slots.version;
    this.#visible.fill(0);
    this.#visible.set(bits.subarray(0, this.#visible.length));
    this.aim();
  }

  /**
   * Whether a frustum is that of the look, bit for bit, and nothing changed since: then what the look did not see cannot be
   * seen with it.
   */
  isOf(frustum: Frustum): boolean {
    if (this.#version !== this.#slots.version || this.camera.layers.mask !== this.#layers) {
      return false;
    }
    const planes = this.#planes;
    for (let number = 0; number < 6; number++) {
      const { normal, constant } = frustum.planes[number];
      const first = 4 * number;
      if (
        planes[first + 3] !== constant ||
        planes[first] !== normal.x ||
        planes[first + 1] !== normal.y ||
        planes[first + 2] !== normal.z
      ) {
        return false;
      }
    }
    return true;
  }

  /** As `isOf`, for a camera that is about to draw. */
  isOfCamera(camera: Camera): boolean {
    if ('isArrayCamera' in camera) {
      return false;
    }
    this.#matrix.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    this.#frustum.setFromProjectionMatrix(this.#matrix, camera.coordinateSystem, camera.reversedDepth);
    return this.isOf(this.#frustum);
  }

  /** Whether a slot was looked for and is not visible. */
  hides(slot: number): boolean {
    const word = slot >>> 5;
    return ((((this.#present[word] ?? 0) & ~(this.#visible[word] ?? 0)) >>> (slot & 31)) & 1) === 1;
  }

  /** Whether a slot was visible. */
  sees(slot: number): boolean {
    return (((this.#visible[slot >>> 5] ?? 0) >>> (slot & 31)) & 1) === 1;
  }

  /** Counts what was looked for, and what was visible of it. */
  counts(): { present: number; visible: number } {
    let [present, visible] = [0, 0];
    for (let word = 0; word < this.#present.length; word++) {
      present += bitCount(this.#present[word]);
      visible += bitCount(this.#present[word] & this.#visible[word]);
    }
    return { present, visible };
  }

  dispose(): void {
    this.viewer.dispose();
  }
}

function bitCount(word: number): number {
  const pairs = word - ((word >>> 1) & 0x55555555);
  const fours = (pairs & 0x33333333) + ((pairs >>> 2) & 0x33333333);
  return (((fours + (fours >>> 4)) & 0x0f0f0f0f) * 0x01010101) >>> 24;
}
