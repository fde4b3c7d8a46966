import type { BatchedMesh, Camera, Frustum, InstancedMesh, LOD, Mesh, Object3D, Plane, Scene } from 'three';
import { REVISION, Vector2 } from 'three';
import { checkOptions, checkViewerOptions, load, type LoadOptions, type ViewerOptions } from '../index.js';
import { BatchedEntry } from './batched.js';
import { type AddOptions, type Entry, MeshEntry, type World } from './entry.js';
import { Meshes } from './geometry.js';
import { InstancedEntry } from './instanced.js';
import { Materials } from './material.js';
import { Slots } from './slots.js';
import { CameraView } from './view.js';

/** What a renderer of three.js tells a culler: `WebGLRenderer` and `WebGPURenderer` do. */
export interface SizedRenderer {
  getDrawingBufferSize(target: Vector2): Vector2;
  /** Of `WebGLRenderer`. */
  getContextAttributes?(): { antialias?: boolean } | null;
  /** Of `WebGPURenderer`. */
  samples?: number;
  /** Of `WebGLRenderer`: planes that clip everything. */
  clippingPlanes?: readonly Plane[];
  /** Of `WebGLRenderer`: whether planes of materials clip. */
  localClippingEnabled?: boolean;
}

/**
 * Options of a culler. `samples` is by default what the renderer has: 4 if it was created with `antialias`, or is
 * unknown. Set it to 4 if you draw to a multisampled render target.
 */
export interface CullerOptions extends LoadOptions, ViewerOptions {
  /** The renderer that draws the pictures: `update` asks it for their size. */
  renderer?: SizedRenderer;
}

/** What the last `update` did. */
export interface CullerStats {
  /** Whether the last update found what is visible. */
  active: boolean;
  /** Objects and instances that were looked for. */
  objects: number;
  /** Those of them that may be visible. */
  visible: number;
  /** Those of them that are not. */
  hidden: number;
  /** Objects and instances that moved since the update before. */
  moved: number;
  /** Meshes that are left to the frustum test of three.js. */
  unculled: number;
  /** Milliseconds for comparing objects with what was handed in before, and for handing in changes. */
  syncMs: number;
  /** Milliseconds for finding out what is visible. */
  lookMs: number;
  /** Triangles of all objects and instances. */
  triangles: number;
}

const size = new Vector2();

/**
 * Occlusion culling for three.js: before each frame, finds out which objects a camera can see, and lets the renderer skip
 * the others. Shadows, other cameras, children and raycasts are as without it.
 *
 * ```js
 * import { EnfiladeCuller } from 'enfilade/three';
 * const culler = await EnfiladeCuller.load({ renderer });
 * culler.addScene(scene);
 * renderer.setAnimationLoop(() => {
 *   culler.update(camera);
 *   renderer.render(scene, camera);
 * });
 * ```
 */
export class EnfiladeCuller {
  /** Whether anything is culled. Default `true`. */
  enabled = true;

  /**
   * While `true`, `update` does not look again: what was visible stays, so that you can move the camera and see what is
   * skipped. Default `false`.
   */
  frozen = false;

  /**
   * Whether `update` compares every object with what it was (default). With `false` it does so only for new objects and
   * those reported to `moved`: for large scenes in which little moves.
   */
  autoUpdate = true;

  readonly stats: CullerStats = {
    active: false,
    objects: 0,
    visible: 0,
    hidden: 0,
    moved: 0,
    unculled: 0,
    syncMs: 0,
    lookMs: 0,
    triangles: 0,
  };

  readonly #options: CullerOptions;
  readonly #slots = new Slots();
  readonly #materials = new Materials();
  readonly #entries = new Map<Object3D, Entry>();
  /** Objects given to `add` and `addScene`. */
  readonly #roots = new Map<Object3D, { options: AddOptions; watches: boolean }>();
  readonly #views: CameraView[] = [];
  readonly #warned = new Set<string>();
  /** Objects that were removed, so that watching does not add them again. */
  readonly #removed = new WeakSet<Object3D>();
  readonly #world: World;
  #moved: Object3D[] = [];
  /** The numbers of the renderer's clipping planes at the last comparison. */
  #planes = '';
  #frame = 0;
  #hasFailed = false;
  #isDisposed = false;

  private constructor(options: CullerOptions) {
    this.#options = options;
    const culler = this;
    this.#world = {
      slots: this.#slots,
      meshes: new Meshes(this.#slots.scene),
      materials: this.#materials,
      planes: [],
      get clipsByMaterial() {
        return culler.#options.renderer?.localClippingEnabled !== false;
      },
      overrideMaterial: null,
      get compares() {
        return culler.autoUpdate && !culler.frozen;
      },
      warn: (once, message) => this.#warn(once, message),
      isOn: (view, frustum) => this.#isOn && view.isOf(frustum),
      hiddenFor: (camera) => {
        const view = this.#isOn && this.#views.find((one) => one.isOfCamera(camera));
        return view ? (slot) => view.hides(slot) : undefined;
      },
    };
  }

  /** Loads the module and creates a culler: one for each scene that you render. */
  static async load(options: CullerOptions = {}): Promise<EnfiladeCuller> {
    if (Number.parseInt(REVISION, 10) < 187) {
      throw new Error(`enfilade: three.js ${REVISION} has no hook for culling; use 0.187 or newer`);
    }
    checkOptions('EnfiladeCuller.load', options, ['renderer', 'samples', 'growthPx', 'tightness', 'wasm', 'simd']);
    checkViewerOptions(options);
    if (options.renderer !== undefined && typeof options.renderer.getDrawingBufferSize !== 'function') {
      throw new TypeError('enfilade: `renderer` is not a renderer of three.js');
    }
    await load({ wasm: options.wasm, simd: options.simd });
    return new EnfiladeCuller(options);
  }

  /**
   * Adds an object with all meshes below it. Meshes that are put below it later are not added: add them too, or use
   * `addScene`. Lines, points and sprites are left to three.js.
   */
  add(object: Object3D, options: AddOptions = {}): this {
    this.#addRoot(object, options, false);
    return this;
  }

  /**
   * Adds everything in a scene, or below another object, and from now on whatever is put there. What was added before keeps its
   * options.
   *
   * ```js
   * culler.addScene(scene, { key: (mesh) => mesh.userData.globalId });
   * ```
   */
  addScene(scene: Object3D, options: AddOptions = {}): this {
    this.#addRoot(scene, options, true);
    return this;
  }

  /** Removes an object, with all meshes below it, until it is added again. It is drawn as without culler. */
  remove(object: Object3D): this {
    mustBeObject('remove', object);
    object.traverse((below) => {
      this.#roots.delete(below);
      this.#removed.add(below);
      this.#forget(below);
    });
    return this;
  }

  /** Reports objects that moved or changed since the last `update`, with what is below them. Needed only if `autoUpdate` is `false`. */
  moved(objects: Object3D | Iterable<Object3D>): this {
    const list = Symbol.iterator in objects ? [...objects] : [objects];
    list.forEach((object) => mustBeObject('moved', object));
    this.#moved.push(...list);
    return this;
  }

  /**
   * Finds out what a camera can see. Call it for each camera that you cull for, when everything is where it will be
   * drawn, right before `render`. A picture drawn with another frustum is not culled.
   *
   * @param width of the picture in device pixels; default: that of the renderer given to `load`. If you draw pictures of
   *   several sizes with one camera, give the largest.
   * @param height of the picture in device pixels
   */
  update(camera: Camera, width?: number, height?: number): void {
    if (this.#isDisposed) {
      this.#warn('disposed', 'update was called on a disposed culler');
      return;
    }
    if (this.#hasFailed) {
      return;
    }
    if (!(camera as Partial<Camera> | undefined)?.isCamera) {
      throw new TypeError('enfilade: update needs a camera');
    }
    if (this.#roots.size === 0) {
      this.#warn('empty', 'nothing was added, so nothing is culled: call addScene(scene) or add(object)');
    }
    if (width === undefined || height === undefined) {
      if (this.#options.renderer === undefined) {
        throw new Error('enfilade: pass the renderer, EnfiladeCuller.load({ renderer }), or the size of the picture, update(camera, width, height)');
      }
      this.#options.renderer.getDrawingBufferSize(size);
      [width, height] = [size.x, size.y];
    }
    try {
      this.#update(camera, width, height);
    } catch (why) {
      if (!(why instanceof WebAssembly.RuntimeError)) {
        throw why;
      }
      this.#hasFailed = true;
      console.error('enfilade: the module failed, so nothing is culled from now on. Please report this.', why);
    }
  }

  #update(camera: Camera, width: number, height: number): void {
    const start = performance.now();
    const view = this.#viewOf(camera);
    if (this.frozen && this.#frame > 0) {
      updateCamera(camera);
      view.aim();
      return;
    }
    this.#materials.begin();
    const planes = this.#options.renderer?.clippingPlanes ?? [];
    this.#world.planes = planes;
    this.#frame++;
    // Planes of the renderer concern all objects.
    const numbers = planes.flatMap(({ normal, constant }) => [normal.x, normal.y, normal.z, constant]).join();
    if (this.autoUpdate || this.#frame === 1 || numbers !== this.#planes) {
      this.#planes = numbers;
      this.#compareAll(camera);
    } else {
      this.#compareMoved();
    }
    this.#moved = [];
    updateCamera(camera);
    this.stats.moved = this.#slots.flush();
    const synced = performance.now();
    this.stats.syncMs = synced - start;
    this.#look(view, Math.max(1, Math.round(width)), Math.max(1, Math.round(height)));
    this.stats.lookMs = performance.now() - synced;
  }

  #look(view: CameraView, width: number, height: number): void {
    try {
      view.look(width, height);
    } catch (why) {
      const { code } = why as { code?: string };
      if (code === undefined) {
        throw why;
      }
      view.forget();
      Object.assign(this.stats, { active: false, objects: 0, visible: 0, hidden: 0 });
      this.#warn(code, `a camera is not culled for: ${(why as Error).message}`);
      return;
    }
    let unculled = 0;
    for (const entry of this.#entries.values()) {
      if (entry.count === 0) {
        unculled++;
      } else {
        entry.seen(view);
      }
    }
    const { present, visible } = view.counts();
    Object.assign(this.stats, {
      active: true,
      objects: present,
      visible,
      hidden: present - visible,
      unculled,
      triangles: this.#slots.scene.triangleCount,
    });
  }

  /**
   * Whether a camera may see an object, or any mesh below it, at its last update; `true` if that is not known.
   *
   * @param camera default: the first that was given to `update`
   * @param instance number of an instance of an `InstancedMesh` or `BatchedMesh`; default: any
   */
  isVisible(object: Object3D, camera?: Camera, instance?: number): boolean {
    const view = this.#viewFor(camera);
    if (view === undefined) {
      return true;
    }
    const entry = this.#entries.get(object);
    if (instance !== undefined) {
      return entry === undefined || entry.count === 0 || !view.hides(entry.first + instance);
    }
    let isKnown = false;
    let isSeen = false;
    object.traverse((below) => {
      const part = this.#entries.get(below);
      if (part !== undefined) {
        isKnown = true;
        isSeen ||= part.count === 0 || part.anySeen(view);
      }
    });
    return isSeen || !isKnown;
  }

  /** Keys of the objects that a camera may see, at its last update. Objects that are left to three.js are not among them. */
  visibleKeys(camera?: Camera): Set<unknown> {
    const view = this.#viewFor(camera);
    const keys = new Set<unknown>();
    for (const entry of this.#entries.values()) {
      if (view && entry.anySeen(view)) {
        keys.add(entry.key);
      }
    }
    return keys;
  }

  /** Objects that were looked for and not seen. */
  hiddenObjects(camera?: Camera): Object3D[] {
    const view = this.#viewFor(camera);
    const entries = view ? [...this.#entries.values()] : [];
    return entries.filter((entry) => entry.isSkipped(view!) && !entry.anySeen(view!)).map((entry) => entry.object);
  }

  /** Stops culling for a camera. */
  removeCamera(camera: Camera): void {
    const number = this.#views.findIndex((view) => view.camera === camera);
    if (number >= 0) {
      const [view] = this.#views.splice(number, 1);
      this.#entries.forEach((entry) => entry.forgetView(view));
      view.dispose();
    }
  }

  /** Undoes all that was done to the objects, and frees the memory. */
  dispose(): void {
    if (this.#isDisposed) {
      return;
    }
    this.#isDisposed = true;
    for (const entry of this.#entries.values()) {
      entry.dispose();
    }
    this.#entries.clear();
    this.#roots.clear();
    this.#views.forEach((view) => view.dispose());
    this.#views.length = 0;
    this.#slots.dispose();
    Object.assign(this.stats, { active: false, objects: 0, visible: 0, hidden: 0, moved: 0 });
  }

  get #isOn(): boolean {
    return this.enabled && !this.#hasFailed && !this.#isDisposed;
  }

  #addRoot(object: Object3D, options: AddOptions, watches: boolean): void {
    mustBeObject(watches ? 'addScene' : 'add', object);
    checkOptions('add', options, ['occluder', 'key']);
    this.#roots.set(object, { options, watches });
    object.traverse((below) => {
      this.#removed.delete(below);
      if (!watches || !this.#entries.has(below)) {
        this.#addEntry(below, options);
      }
    });
  }

  #addEntry(object: Object3D, options: AddOptions): void {
    if (!('isMesh' in object) || object.userData.enfilade === true) {
      return;
    }
    if (this.#entries.has(object)) {
      this.#forget(object);
    }
    const mesh = object as Mesh;
    const entry = (
      'isInstancedMesh' in object
        ? new InstancedEntry(mesh as InstancedMesh, options, this.#world)
        : 'isBatchedMesh' in object
          ? new BatchedEntry(mesh as BatchedMesh, options, this.#world)
          : new MeshEntry(mesh, options, this.#world)
    ) as Entry;
    entry.hook((hooked, frustum) => this.#isSkipped(hooked, frustum));
    this.#entries.set(object, entry);
    if (!this.autoUpdate) {
      this.#moved.push(object);
    }
  }

  #forget(object: Object3D): void {
    this.#entries.get(object)?.dispose();
    this.#entries.delete(object);
  }

  /** What the renderer asks of each object that it may draw. */
  #isSkipped(entry: Entry, frustum: Frustum): boolean {
    if (!this.#isOn || entry.count === 0) {
      return false;
    }
    // An array of frusta, of several cameras at once, has no planes.
    const view = frustum.planes && this.#views.find((one) => one.isOf(frustum));
    return view !== undefined && entry.isSkipped(view);
  }

  #viewFor(camera: Camera | undefined): CameraView | undefined {
    return camera ? this.#views.find((one) => one.camera === camera) : this.#views[0];
  }

  #viewOf(camera: Camera): CameraView {
    let view = this.#views.find((one) => one.camera === camera);
    if (view === undefined) {
      const { tightness, growthPx, renderer, samples = samplesOf(renderer) } = this.#options;
      view = new CameraView(camera, this.#slots, { tightness, growthPx, samples });
      this.#views.push(view);
    }
    return view;
  }

  /** Hands in everything that is drawn, as it is now. */
  #compareAll(camera: Camera): void {
    const scene = this.#updateMatrices();
    this.#world.overrideMaterial = (scene as Partial<Scene> | undefined)?.overrideMaterial ?? null;
    for (const [root, { options, watches }] of this.#roots) {
      if (scene === undefined || topOf(root) === scene) {
        if (isShown(root)) {
          this.#visit(root, camera, watches ? options : undefined);
        }
      }
    }
    for (const [object, entry] of this.#entries) {
      if (entry.frame !== this.#frame) {
        this.#slots.isQuiet = object.parent !== null && isLod(object.parent) && isShown(object.parent);
        entry.hide();
        this.#slots.isQuiet = false;
        this.#forgetIfGone(object);
      }
    }
  }

  /** As the renderer goes through a scene: what is invisible is not drawn, nor what is below it. */
  #visit(object: Object3D, camera: Camera, watching: AddOptions | undefined): void {
    if (!object.visible) {
      return;
    }
    const wasQuiet = this.#slots.isQuiet;
    if (isLod(object)) {
      object.update(camera);
      this.#slots.isQuiet = true;
    }
    if ('isMesh' in object) {
      if (watching && !this.#entries.has(object) && !this.#removed.has(object)) {
        this.#addEntry(object, watching);
      }
      const entry = this.#entries.get(object);
      if (entry && entry.frame !== this.#frame) {
        entry.frame = this.#frame;
        entry.refresh();
      }
    }
    const { planes } = this.#world;
    this.#world.planes = withPlanesOf(object, planes);
    for (const child of object.children) {
      this.#visit(child, camera, watching);
    }
    this.#world.planes = planes;
    this.#slots.isQuiet = wasQuiet;
  }

  /** Hands in the objects that were reported. */
  #compareMoved(): void {
    for (const object of this.#moved) {
      object.updateWorldMatrix(true, true);
      object.traverse((below) => {
        const entry = this.#entries.get(below);
        if (entry === undefined) {
          return;
        }
        if (isShown(below)) {
          entry.frame = this.#frame;
          const { planes } = this.#world;
          for (let above = below.parent; above !== null; above = above.parent) {
            this.#world.planes = withPlanesOf(above, this.#world.planes);
          }
          entry.refresh();
          this.#world.planes = planes;
        } else {
          entry.hide();
        }
      });
    }
  }

  /** Updates the matrices of everything that was added, and returns the scene that is drawn. */
  #updateMatrices(): Object3D | undefined {
    const tops = new Set<Object3D>();
    for (const root of this.#roots.keys()) {
      tops.add(topOf(root));
    }
    const scenes = [...tops].filter((top) => 'isScene' in top);
    if (scenes.length > 1) {
      this.#warn('scenes', 'objects of several scenes were added; only those of the first are culled. Use a culler for each scene.');
    }
    for (const top of tops) {
      if (top.matrixWorldAutoUpdate) {
        top.updateMatrixWorld();
      }
    }
    return scenes[0] ?? [...tops][0];
  }

  /** Forgets an object that was taken out of what is watched. */
  #forgetIfGone(object: Object3D): void {
    for (let above: Object3D | null = object; above !== null; above = above.parent) {
      if (this.#roots.has(above)) {
        return;
      }
    }
    this.#forget(object);
  }

  #warn(once: string, message: string): void {
    if (!this.#warned.has(once)) {
      this.#warned.add(once);
      console.warn(`enfilade: ${message}`);
    }
  }
}

function samplesOf(renderer: SizedRenderer | undefined): 1 | 4 {
  const antialias = renderer?.getContextAttributes?.()?.antialias ?? (renderer?.samples ?? 4) > 0;
  return antialias ? 4 : 1;
}

function mustBeObject(method: string, object: Object3D): void {
  if (!(object as Partial<Object3D> | undefined)?.isObject3D) {
    throw new TypeError(`enfilade: ${method} needs an Object3D`);
  }
}

/** Returns planes with those by which a group clips what is below it. */
function withPlanesOf(object: Object3D, planes: readonly Plane[]): readonly Plane[] {
  const { isClippingGroup, enabled, clippingPlanes } = object as { isClippingGroup?: boolean; enabled?: boolean; clippingPlanes?: Plane[] };
  return isClippingGroup && enabled && clippingPlanes ? [...planes, ...clippingPlanes] : planes;
}

function updateCamera(camera: Camera): void {
  camera.updateWorldMatrix(true, false);
}

/** Whether an object is one whose level of detail each camera chooses when it draws. */
function isLod(object: Object3D): object is LOD {
  return 'isLOD' in object && (object as LOD).autoUpdate;
}

function topOf(object: Object3D): Object3D {
  let top = object;
  while (top.parent !== null) {
    top = top.parent;
  }
  return top;
}

/** Whether an object and everything above it is visible. */
function isShown(object: Object3D): boolean {
  for (let above: Object3D | null = object; above !== null; above = above.parent) {
    if (!above.visible) {
      return false;
    }
  }
  return true;
}

