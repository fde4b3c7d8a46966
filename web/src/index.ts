/**
 * Visibility without a renderer: hand in meshes or boxes and their transforms, then ask which a camera can see.
 *
 * ```js
 * import { load, Scene, Viewer } from 'enfilade';
 * await load();
 * const scene = new Scene();
 * const wall = scene.addMesh({ positions, indices });
 * scene.add([0, 1], [wall, wall], transforms); // keys, meshes, 16 numbers each
 * const viewer = new Viewer();
 * viewer.look(scene, viewMatrix, projectionMatrix, { width, height });
 * if (viewer.sees(1)) draw(1);
 * ```
 *
 * For three.js see `enfilade/three`, for files with rooms and portals `enfilade/files`.
 */
import { Loader, type LoadOptions } from './load.js';
import * as core from '../wasm/core.js';

export { hasSimd } from './load.js';
export type { LoadOptions, WasmSource } from './load.js';

const loader = new Loader(core, {
  simd: new URL('../wasm/core_bg.wasm', import.meta.url),
  plain: new URL('../wasm/core_plain_bg.wasm', import.meta.url),
});

/**
 * Loads the module, once. Everything else in this package needs it. Works in a worker too, and needs neither threads
 * nor cross-origin isolation.
 */
export function load(options: LoadOptions = {}): Promise<void> {
  return loader.load(options);
}

/** Which sides of a triangle are drawn; the front is the one from which its vertices are counter-clockwise. */
export type Side = 'front' | 'back' | 'double';

/** A part of a mesh with a material of its own. */
export interface MeshGroup {
  /** First index, or first vertex of a mesh without indices. */
  start: number;
  /** Number of indices. */
  count: number;
  /** Default `'front'`. */
  side?: Side;
  /** Whether one can see through it, as through glass or foliage: then it hides nothing. Default `false`. */
  seeThrough?: boolean;
}

/** Triangles in the space of their object. */
export interface MeshData {
  /** x, y, z of each vertex. */
  positions: Float32Array;
  /** Three vertices per triangle. Default: the vertices in order. */
  indices?: Uint32Array | Uint16Array | null;
  /** Default: one part of everything. What no group contains is not there. */
  groups?: MeshGroup[];
}

/** Options of an object. */
export interface ItemOptions {
  /** Whether it may hide others. Default `true`. Use `false` for what a shader moves, cuts out or blends. */
  occluder?: boolean;
  /** Whether it counts as visible wherever it is, also behind the camera. Default `false`. */
  alwaysVisible?: boolean;
  /** A bit for each layer that it is in; see `LookOptions.layers`. With 0 it is neither visible nor hides others. Default: all. */
  layers?: number;
}

const sideBits: Record<Side, number> = { front: 0, double: 1, back: 4 };

/**
 * Objects, each with a mesh or box, a transform and a key.
 *
 * Keys are your numbers for the objects, from 0 and without large gaps. An object that cannot be where it is said to be
 * (a transform with NaN, or beyond 10^15) counts as visible until it is moved.
 */
export class Scene {
  #scene: core.Scene;

  constructor() {
    this.#scene = new loader.glue.Scene();
  }

  /** @internal */
  get raw(): core.Scene {
    return this.#scene;
  }

  /**
   * Adds a mesh and returns its number. What it hides must be what you draw: not a coarser level, nor a mesh that a
   * shader deforms.
   *
   * @throws an `Error` with a `code` such as `mesh/not-finite`, if a position is not finite or an index out of range.
   */
  addMesh({ positions, indices, groups }: MeshData): number {
    const all: MeshGroup[] = groups ?? [{ start: 0, count: indices?.length ?? positions.length / 3 }];
    const numbers = all.flatMap(({ start, count, side = 'front', seeThrough = false }) => [
      start,
      Math.min(count, 0xffffffff),
      sideBits[side] | (seeThrough ? 2 : 0),
    ]);
    return this.#scene.addMesh(positions, new Uint32Array(indices ?? []), new Uint32Array(numbers));
  }

  /**
   * Adds a box and returns its number, as a mesh. Its objects are visible where it may be, and hide nothing: for what
   * has no triangles, or is animated (a box around all its poses).
   */
  addBox(min: ArrayLike<number>, max: ArrayLike<number>): number {
    return this.#scene.addBox(new Float32Array([min[0], min[1], min[2], max[0], max[1], max[2]]));
  }

  /** Forgets a mesh or box. Objects that have it keep it. */
  removeMesh(mesh: number): void {
    this.#scene.removeMesh(mesh);
  }

  /**
   * Adds objects, or replaces those with the same keys.
   *
   * @param keys a number for each object
   * @param meshes the mesh of each object, from `addMesh` or `addBox`
   * @param transforms 16 numbers for each object: the columns of the matrix from its space to that of the world
   * @param options for all, or an array with one for each
   */
  add(keys: ArrayLike<number>, meshes: ArrayLike<number>, transforms: Float32Array, options: ItemOptions | ItemOptions[] = {}): void {
    const { flags, layers } = optionBits(keys.length, options);
    this.#scene.add(words(keys), words(meshes), transforms, flags, layers);
  }

  /** Moves objects: 16 numbers for each key, the columns of its matrix. Keys without an object are ignored. */
  setTransforms(keys: ArrayLike<number>, transforms: Float32Array): void {
    this.#scene.setTransforms(words(keys), transforms);
  }

  /** Gives objects other meshes. */
  setMeshes(keys: ArrayLike<number>, meshes: ArrayLike<number>): void {
    this.#scene.setMeshes(words(keys), words(meshes));
  }

  /** Replaces the options of objects. */
  setOptions(keys: ArrayLike<number>, options: ItemOptions | ItemOptions[]): void {
    const { flags, layers } = optionBits(keys.length, options);
    this.#scene.setOptions(words(keys), flags, layers);
  }

  /** Removes objects. Keys without an object are ignored. */
  remove(keys: ArrayLike<number>): void {
    this.#scene.remove(words(keys));
  }

  /** Number of objects. */
  get itemCount(): number {
    return this.#scene.itemCount;
  }

  /** Number of triangles of all objects. */
  get triangleCount(): number {
    return this.#scene.triangleCount;
  }

  /** Approximate size in memory, in bytes. */
  get bytes(): number {
    return this.#scene.bytes;
  }

  /** Frees the memory. Do not use it afterwards. */
  dispose(): void {
    this.#scene.free();
  }
}

/** Options of `Viewer.look`. */
export interface LookOptions {
  /** Width of the picture in pixels, device pixels: what the renderer draws to. */
  width: number;
  /** Height of the picture in pixels. */
  height: number;
  /**
   * Depth of the near and far planes in clip space: `'-1..1'` for WebGL, `'0..1'` for WebGPU, `'1..0'` for reversed
   * depth. Default `'-1..1'`.
   */
  depth?: '-1..1' | '0..1' | '1..0';
  /** A bit for each layer to look at. Default: all. */
  layers?: number;
}

/** Options of a viewer. */
export interface ViewerOptions {
  /**
   * What is tested at the end of a look: `'boxes'` (default), also `'faces'`, or faces at the exact depths of doubtful
   * pixels (`'resolved'`). Each finds more hidden objects than the one before, and takes longer.
   */
  tightness?: 'boxes' | 'faces' | 'resolved';
  /**
   * Samples of a pixel: 1 (default), or 4 if the picture is multisampled (`antialias` of WebGL and three.js). With 4, each
   * of the usual sample positions is looked at, which takes four times as long.
   */
  samples?: 1 | 4;
  /**
   * How far tested boxes grow on the screen, in pixels on each side, 0 to 8. Default 1: GPUs move vertices a little, and
   * what then shows beside an occluder must not be skipped. With 0, sets are true of the exact picture.
   */
  growthPx?: number;
}

/** @internal */
export const depths = { '-1..1': 0, '0..1': 1, '1..0': 2 };
/** @internal */
export const tightnesses = { boxes: 0, faces: 1, resolved: 2 };

/** A camera, and what it saw last. Keep one for each camera: what it saw makes the next look cheaper. */
export class Viewer {
  #viewer: core.Viewer;

  constructor(options: ViewerOptions = {}) {
    checkOptions('Viewer', options, ['tightness', 'samples', 'growthPx']);
    checkViewerOptions(options);
    const { tightness = 'boxes', samples = 1, growthPx = 1 } = options;
    this.#viewer = new loader.glue.Viewer(tightnesses[tightness], growthPx, samples);
  }

  /**
   * Determines what is visible.
   *
   * @param viewMatrix 16 numbers, the columns of the matrix from the world to the camera, y up
   * @param projectionMatrix 16 numbers: a perspective or parallel (orthographic) projection
   * @throws an `Error` with a `code`: `view/singular` for a matrix without an inverse, `view/clip-depth` for a wrong `depth`
   */
  look(scene: Scene, viewMatrix: ArrayLike<number>, projectionMatrix: ArrayLike<number>, options: LookOptions): void {
    const { width, height, depth = '-1..1', layers = 0xffffffff } = checkLook(options);
    this.#viewer.look(scene.raw, doubles(viewMatrix), doubles(projectionMatrix), depths[depth], width, height, layers >>> 0);
  }

  /** Returns `true` if the object with this key may be visible. */
  sees(key: number): boolean {
    return key >>> 5 < this.#viewer.bitsLength && ((this.bits[key >>> 5] >>> (key & 31)) & 1) === 1;
  }

  /**
   * One bit per key, 32 in a word: set if the object may be visible. A view of the module's memory: do not keep it
   * longer than to the next call.
   */
  get bits(): Uint32Array {
    return loader.words(this.#viewer.bitsAddress, this.#viewer.bitsLength);
  }

  /** Keys of the visible objects, ascending. A view of the module's memory, as `bits`. */
  get visible(): Uint32Array {
    return loader.words(this.#viewer.listsAddress, this.#viewer.visibleCount);
  }

  /** Keys that became visible with the last look. A view of the module's memory, as `bits`. */
  get entered(): Uint32Array {
    return loader.words(this.#viewer.listsAddress + 4 * this.#viewer.visibleCount, this.#viewer.enteredCount);
  }

  /** Keys that were visible before the last look and no longer are. A view of the module's memory, as `bits`. */
  get left(): Uint32Array {
    const before = this.#viewer.visibleCount + this.#viewer.enteredCount;
    return loader.words(this.#viewer.listsAddress + 4 * before, this.#viewer.leftCount);
  }

  /**
   * Whether the matrices of the last look mirror, so that faces that are counter-clockwise in the world appear clockwise. The
   * answer holds for a renderer that draws the same sides as without: flip its winding, or draw everything.
   */
  get isMirrored(): boolean {
    return this.#viewer.isMirrored;
  }

  /** Frees the memory. Do not use it afterwards. */
  dispose(): void {
    this.#viewer.free();
  }
}

/** Throws if the options of a look are not there. @internal */
export function checkLook(options: LookOptions): LookOptions {
  if (typeof options?.width !== 'number' || typeof options.height !== 'number') {
    throw new TypeError('enfilade: look needs { width, height } after the matrices');
  }
  if (options.depth !== undefined && !(options.depth in depths)) {
    throw new RangeError(`enfilade: depth is '${options.depth}'; it can be ${Object.keys(depths).join(', ')}`);
  }
  return options;
}

/** Throws if an option has a name that there is not. @internal */
export function checkOptions(of: string, options: object, names: string[]): void {
  for (const name of Object.keys(options)) {
    if (!names.includes(name)) {
      throw new TypeError(`enfilade: ${of} has no option '${name}'; it has ${names.join(', ')}`);
    }
  }
}

/** Throws if an option of a viewer has a value that it cannot have. @internal */
export function checkViewerOptions({ tightness = 'boxes', samples = 1, growthPx = 1 }: ViewerOptions): void {
  if (!(tightness in tightnesses)) {
    throw new RangeError(`enfilade: tightness is '${tightness}'; it can be ${Object.keys(tightnesses).join(', ')}`);
  }
  if (samples !== 1 && samples !== 4) {
    throw new RangeError(`enfilade: samples is ${samples}; it can be 1 or 4`);
  }
  if (typeof growthPx !== 'number' || !(growthPx >= 0 && growthPx <= 8)) {
    throw new RangeError(`enfilade: growthPx is ${growthPx}; it can be 0 to 8`);
  }
}

function words(numbers: ArrayLike<number>): Uint32Array {
  if (numbers instanceof Uint32Array) {
    return numbers;
  }
  return Uint32Array.from(numbers, (number) => {
    if (!Number.isInteger(number) || number < 0) {
      throw new TypeError(`enfilade: ${String(number)} is neither a key nor a mesh; both are whole numbers from 0`);
    }
    return number;
  });
}

function doubles(numbers: ArrayLike<number>): Float64Array {
  return numbers instanceof Float64Array ? numbers : Float64Array.from(numbers);
}

function optionBits(count: number, options: ItemOptions | ItemOptions[]): { flags: Uint32Array; layers: Uint32Array } {
  const flags = new Uint32Array(count);
  const layers = new Uint32Array(count);
  for (let number = 0; number < count; number++) {
    const { occluder = true, alwaysVisible = false, layers: mask = 0xffffffff } = Array.isArray(options)
      ? options[number]
      : options;
    flags[number] = (occluder ? 1 : 0) | (alwaysVisible ? 2 : 0);
    layers[number] = mask;
  }
  return { flags, layers };
}
