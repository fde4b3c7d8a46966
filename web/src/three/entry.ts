import { Matrix4, Vector3, type BufferGeometry, type Camera, type Frustum, type Material, type Mesh, type Plane } from 'three';
import { Draws, type Materials, materialsOf } from './material.js';
import { Box, type Meshes, Poses, groupsOf, isMorphed, isSkinned, positionsOf, versionOf } from './geometry.js';
import { hookMesh } from './hooks.js';
import type { Slots } from './slots.js';
import type { CameraView } from './view.js';

/** What the entries of a culler share. */
export interface World {
  slots: Slots;
  meshes: Meshes;
  materials: Materials;
  /** Whether objects are compared with what was handed in before they are culled. */
  readonly compares: boolean;
  /** Planes that clip what is handed in now: those of the renderer, and of the groups that it is in. */
  planes: readonly Plane[];
  /** Whether planes of materials clip. */
  readonly clipsByMaterial: boolean;
  /** What all objects are drawn with, if the scene says so. */
  overrideMaterial: Material | null;
  warn(once: string, message: string): void;
  /** Whether a frustum is culled for a view now. */
  isOn(view: CameraView, frustum: Frustum): boolean;
  /** Returns which slots a camera that is about to draw does not see; `undefined` if that is not known. */
  hiddenFor(camera: Camera): ((slot: number) => boolean) | undefined;
}

/** How `add` describes an object. */
export interface AddOptions {
  /**
   * Whether it hides others. Default: if its material is opaque and moves no vertices, as far as can be known. With
   * `true` you vouch for it: what its triangles cover is opaque, where the geometry says.
   */
  occluder?: boolean;
  /**
   * What visible sets call it, or a function that returns that for each mesh. Default: the mesh itself. Several meshes may
   * have the same key.
   */
  key?: unknown;
}

const scratch = new Matrix4();
const corner = new Vector3();
const elements = new Array<number>(16).fill(0);

/** An object that the culler knows. */
export abstract class Entry<T extends Mesh = Mesh> {
  /** Number of the last update in which it was drawn. */
  frame = -1;
  /** First of its slots, and their number. */
  first = 0;
  count = 0;
  /** The meshes that it has taken. */
  #meshNames: { geometry: BufferGeometry; name: string }[] = [];
  #unhook = () => {};

  constructor(
    readonly object: T,
    readonly options: AddOptions,
    protected readonly world: World,
  ) {}

  get key(): unknown {
    const { key } = this.options;
    return (typeof key === 'function' ? (key as (object: Mesh) => unknown)(this.object) : key) ?? this.object;
  }

  /** Hooks the object: it is not drawn if `isSkipped` says so, nor if its own test does. */
  hook(isSkipped: (entry: Entry, frustum: Frustum) => boolean): void {
    this.#unhook = hookMesh(this.object, (frustum) => isSkipped(this, frustum));
  }

  /** Hands the object in as it is now. */
  abstract refresh(): void;

  /** Whether it need not be drawn in a view. */
  abstract isSkipped(view: CameraView): boolean;

  /** Whether any part of it was visible, or may have been. */
  anySeen(view: CameraView): boolean {
    for (let slot = this.first; slot < this.first + this.count; slot++) {
      if (view.sees(slot)) {
        return true;
      }
    }
    return !view.isKnown;
  }

  /** Called after a look. */
  seen(_view: CameraView): void {}

  /** Called when a camera is no longer culled for. */
  forgetView(_view: CameraView): void {}

  /** Keeps it out of the scene until the next refresh. */
  hide(): void {
    for (let slot = this.first; slot < this.first + this.count; slot++) {
      this.world.slots.hide(slot);
    }
  }

  /** Leaves it to three.js. */
  protected leave(): void {
    this.reserve(0);
  }

  /** Makes room for that many slots. */
  protected reserve(count: number): void {
    if (count !== this.count) {
      if (this.count > 0) {
        this.world.slots.giveBack(this.first, this.count);
      }
      this.first = count > 0 ? this.world.slots.take(count) : 0;
      this.count = count;
    }
  }

  /** Whether its opaque parts hide others. */
  protected get isOccluder(): boolean {
    return (this.options.occluder ?? this.object.frustumCulled) && !this.isCut();
  }

  /** Whether planes may cut anything off: then that does not hide what is behind. */
  protected isCut(): boolean {
    return this.planes().length > 0;
  }

  /** Planes that clip it. */
  protected planes(): readonly Plane[] {
    const { planes, clipsByMaterial } = this.world;
    const { material } = this;
    if (!clipsByMaterial || material === undefined) {
      return planes;
    }
    const own = (Array.isArray(material) ? material : [material]).flatMap((one) => one?.clippingPlanes ?? []);
    return own.length > 0 ? [...planes, ...own] : planes;
  }

  /** What it is drawn with. */
  protected get material(): Material | Material[] | undefined {
    return this.world.overrideMaterial ?? materialsOf(this.object);
  }

  /** `Draws` of all its materials together. */
  protected draws(): number {
    const trusted = this.options.occluder === true;
    const { material } = this;
    if (material === undefined) {
      return Draws.Nothing;
    }
    if (!Array.isArray(material)) {
      return this.world.materials.of(material, trusted) & 15;
    }
    let all = 0;
    let nothing = Draws.Nothing as number;
    for (const one of material) {
      const draws = one ? this.world.materials.of(one, trusted) : Draws.Nothing;
      all |= draws & 7;
      nothing &= draws;
    }
    return all | nothing;
  }

  /** Returns the kinds of the object's materials: meshes differ by them. */
  protected kinds(): number | string {
    const trusted = this.options.occluder === true;
    const material = this.material!;
    const kind = (one: Material) => (one ? this.world.materials.of(one, trusted) : Draws.Nothing);
    return Array.isArray(material) ? material.map(kind).join() : kind(material);
  }

  /** Returns the mesh of a geometry with the object's materials; `undefined` if the culler cannot have it. */
  protected takeMesh(geometry: BufferGeometry, kinds: number | string): number | undefined {
    const positions = positionsOf(geometry);
    if (positions === undefined) {
      return undefined;
    }
    const { start, count } = geometry.drawRange;
    const name = `${versionOf(geometry)} ${start} ${count} ${typeof kinds} ${kinds}`;
    return this.takeNamed(geometry, name, () => {
      const groups = groupsOf(geometry, typeof kinds === 'number' ? kinds : kinds.split(',').map(Number));
      return this.world.slots.scene.addMesh({ positions, indices: indicesOf(geometry), groups });
    });
  }

  /** Takes a mesh by name, or builds it; `undefined` if the scene refuses it. */
  protected takeNamed(geometry: BufferGeometry, name: string, build: () => number): number | undefined {
    try {
      const mesh = this.world.meshes.take(geometry, name, build);
      this.#meshNames.push({ geometry, name });
      return mesh;
    } catch (why) {
      if (why instanceof WebAssembly.RuntimeError) {
        throw why;
      }
      const { name: label, type, id } = this.object;
      this.world.warn('mesh', `'${label || type}' (id ${id}) is not culled: ${(why as Error).message}`);
      return undefined;
    }
  }

  /**
   * Calls `take`, which takes other meshes, then gives back those that were taken before. Not in the other order: a number that
   * is free would be given to another mesh, and nothing seem to have changed.
   */
  protected retake(take: () => void): void {
    const before = this.#meshNames;
    this.#meshNames = [];
    take();
    for (const { geometry, name } of before) {
      this.world.meshes.giveBack(geometry, name);
    }
  }

  dispose(): void {
    this.#unhook();
    this.reserve(0);
    this.retake(() => {});
  }
}

function indicesOf(geometry: BufferGeometry): Uint32Array | Uint16Array | undefined {
  const array = geometry.index?.array;
  if (array === undefined || array instanceof Uint32Array || array instanceof Uint16Array) {
    return array;
  }
  return Uint32Array.from(array);
}

/** Sets `elements` to the matrix of a box around the bounding sphere of a geometry, in the space of its object. */
export function sphereMatrix(object: { geometry: BufferGeometry }, matrixWorld: Matrix4, grown: number, into: number[]): void {
  const { geometry } = object;
  if (geometry.boundingSphere === null) {
    geometry.computeBoundingSphere();
  }
  const { center, radius } = geometry.boundingSphere!;
  const r = radius + grown;
  scratch.makeScale(2 * r, 2 * r, 2 * r).setPosition(center.x - r, center.y - r, center.z - r);
  scratch.premultiply(matrixWorld).toArray(into);
}

/** How far displacement moves a vertex at most. */
export function displacement(material: Material | Material[]): number {
  const list = Array.isArray(material) ? material : [material];
  return list.reduce((most, one) => {
    const { displacementMap, displacementScale = 1, displacementBias = 0 } = one as unknown as {
      displacementMap?: object | null;
      displacementScale?: number;
      displacementBias?: number;
    };
    return displacementMap ? Math.max(most, Math.abs(displacementBias), Math.abs(displacementScale + displacementBias)) : most;
  }, 0);
}

/** Whether a shader puts instances where only it knows. */
export function isInstancedByGeometry(geometry: BufferGeometry): boolean {
  return (geometry as { isInstancedBufferGeometry?: boolean }).isInstancedBufferGeometry === true;
}

/** A mesh: by its triangles, or by a box that follows its pose. */
export class MeshEntry extends Entry {
  #geometry: BufferGeometry | undefined;
  #kinds: number | string = -1;
  #version = -1;
  #start = 0;
  #end = 0;
  #mesh: number | undefined;
  #poses: Poses | undefined;
  #box = new Box();
  #usesBox = false;
  /** Version of the geometry that its bounding box is of. */
  #boxVersion = -1;

  refresh(): void {
    const { object, world } = this;
    const { geometry } = object;
    const draws = this.draws();
    const isPosed = isSkinned(object) || isMorphed(object);
    if (draws & Draws.Through || (isSkinned(object) && isMorphed(object)) || isInstancedByGeometry(geometry)) {
      this.leave();
      return;
    }
    if (draws & Draws.Nothing) {
      this.hide();
      return;
    }
    const layers = object.layers.mask >>> 0;
    this.#usesBox = isPosed || (draws & Draws.Moves) !== 0;
    if (this.#usesBox) {
      if (positionsOf(geometry) === undefined) {
        this.leave();
        return;
      }
      if (isPosed) {
        if (!this.#poses?.isOf(object)) {
          this.#poses = new Poses(object);
        }
        this.#poses.bounds(this.#box, scratch);
        this.#box.toMatrix(elements);
      }
      if (!isPosed || draws & Draws.Moves) {
        sphereMatrix(object, object.matrixWorld, displacement(this.material!), elements);
      }
      this.reserve(1);
      world.slots.put(this.first, world.meshes.unitBox, elements, false, layers);
      return;
    }
    const kinds = this.kinds();
    const version = versionOf(geometry);
    const { start, count } = geometry.drawRange;
    if (geometry !== this.#geometry || kinds !== this.#kinds || version !== this.#version || start !== this.#start || count !== this.#end) {
      this.retake(() => (this.#mesh = this.takeMesh(geometry, kinds)));
      [this.#geometry, this.#kinds, this.#version, this.#start, this.#end] = [geometry, kinds, version, start, count];
    }
    if (this.#mesh === undefined) {
      this.leave();
      return;
    }
    this.reserve(1);
    world.slots.put(this.first, this.#mesh, object.matrixWorld.elements, this.isOccluder, layers);
  }

  /** A mesh is cut unless all of it is on the side that is kept. */
  protected override isCut(): boolean {
    const planes = this.planes();
    if (planes.length === 0) {
      return false;
    }
    const { geometry, matrixWorld } = this.object;
    if (geometry.boundingBox === null || this.#boxVersion !== this.#version) {
      geometry.computeBoundingBox();
      this.#boxVersion = this.#version;
    }
    const { min, max } = geometry.boundingBox!;
    return planes.some((plane) => {
      for (let number = 0; number < 8; number++) {
        corner.set(number & 1 ? max.x : min.x, number & 2 ? max.y : min.y, number & 4 ? max.z : min.z);
        if (!(plane.distanceToPoint(corner.applyMatrix4(matrixWorld)) >= 0)) {
          return true;
        }
      }
      return false;
    });
  }

  isSkipped(view: CameraView): boolean {
    return this.count > 0 && view.hides(this.first) && (!this.world.compares || this.#isAsLookedAt());
  }

  /** Whether it is still as it was in the last update. */
  #isAsLookedAt(): boolean {
    const { object, world } = this;
    if (this.#usesBox) {
      // Its pose is compared by its bones only in the next update.
      return true;
    }
    return object.geometry === this.#geometry && world.slots.isAt(this.first, object.matrixWorld.elements, object.layers.mask >>> 0);
  }
}
