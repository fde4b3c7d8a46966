import { Matrix4, type BatchedMesh, type BufferGeometry, type Camera } from 'three';
import { Draws, groupOptions } from './material.js';
import { positionsOf, versionOf } from './geometry.js';
import { Entry, type AddOptions, type World, displacement } from './entry.js';
import type { CameraView } from './view.js';

/** What three.js 0.187 keeps for each instance of a batch, and offers no other way to read at once. */
interface Internals {
  _instanceInfo: { visible: boolean; active: boolean; geometryIndex: number }[];
  _matricesTexture: { version: number; image: { data: Float32Array } };
  _visibilityChanged: boolean;
  _updateDrawParameters(camera: Camera, geometry: BufferGeometry, ...others: unknown[]): void;
}

const matrix = new Matrix4();
const sphere = { center: { x: 0, y: 0, z: 0 }, radius: 0 };

/** The objects of a batch, each culled by itself. */
export class BatchedEntry extends Entry<BatchedMesh> {
  #geometries = new Map<number, number | undefined>();
  #state: unknown[] = [];
  readonly #internals: Internals;

  constructor(object: BatchedMesh, options: AddOptions, world: World) {
    super(object, options, world);
    this.#internals = object as unknown as Internals;
    const internals = this.#internals;
    const update = internals._updateDrawParameters;
    // Called before each draw, of each camera and each light. The list of draws is made of those instances that are
    // visible; the ones that this camera does not see are not, for as long.
    internals._updateDrawParameters = (camera, ...others) => {
      const hidden = world.hiddenFor(camera, this);
      if (hidden === undefined) {
        update.call(object, camera, ...others);
        return;
      }
      const infos = internals._instanceInfo;
      const off = infos.filter((info, number) => info.visible && hidden(this.first + number));
      off.forEach((info) => (info.visible = false));
      internals._visibilityChanged = true;
      update.call(object, camera, ...others);
      off.forEach((info) => (info.visible = true));
      // Made anew for the next camera.
      internals._visibilityChanged = true;
    };
  }

  refresh(): void {
    const { object, world, options } = this;
    const { geometry } = object;
    const draws = this.draws();
    const internals = this.#internals;
    const infos = internals._instanceInfo;
    if (draws & Draws.Through || infos === undefined || internals._matricesTexture === undefined) {
      this.leave();
      return;
    }
    if (draws & Draws.Nothing) {
      this.hide();
      return;
    }
    const kinds = this.kinds();
    const state = [geometry, versionOf(geometry), kinds];
    if (!state.every((value, number) => value === this.#state[number])) {
      this.giveBackMeshes();
      this.#geometries.clear();
      this.#state = state;
    }
    this.reserve(infos.length);
    const isBox = (draws & Draws.Moves) !== 0;
    const isOccluder = (options.occluder ?? object.frustumCulled) && !isBox;
    const layers = object.layers.mask >>> 0;
    const matrices = internals._matricesTexture.image.data;
    const grown = displacement(object.material);
    infos.forEach((info, number) => {
      const slot = this.first + number;
      const mesh = info.active && info.visible ? this.#meshOf(info.geometryIndex, kinds, isBox) : undefined;
      if (mesh === undefined) {
        world.slots.drop(slot);
        return;
      }
      matrix.fromArray(matrices, 16 * number).premultiply(object.matrixWorld);
      if (isBox) {
        object.getBoundingSphereAt(info.geometryIndex, sphere as never);
        const r = sphere.radius + grown;
        const { x, y, z } = sphere.center;
        matrix.multiply(new Matrix4().makeScale(2 * r, 2 * r, 2 * r).setPosition(x - r, y - r, z - r));
      }
      world.slots.put(slot, mesh, matrix.elements, isOccluder, layers);
    });
  }

  /** Returns the mesh of a geometry of the batch. */
  #meshOf(id: number, kinds: number | string, isBox: boolean): number | undefined {
    if (isBox) {
      return this.world.meshes.unitBox;
    }
    if (this.#geometries.has(id)) {
      return this.#geometries.get(id);
    }
    const { geometry } = this.object;
    const { vertexStart, vertexCount, indexStart, start, count } = this.object.getGeometryRangeAt(id)!;
    const all = positionsOf(geometry);
    // A batch has one material, or as many as there are groups, which do not apply to it.
    const kind = typeof kinds === 'number' ? kinds : undefined;
    const mesh =
      all === undefined || kind === undefined
        ? undefined
        : this.takeNamed(geometry, `${versionOf(geometry)} part ${id} ${kind}`, () => {
            const index = geometry.index?.array;
            const indices = index && Uint32Array.from(index.subarray(start, start + count), (vertex) => vertex - vertexStart);
            return this.world.slots.scene.addMesh({
              positions: all.slice(3 * vertexStart, 3 * (vertexStart + vertexCount)),
              indices,
              groups: [{ start: indexStart >= 0 || index ? 0 : start - vertexStart, count, ...groupOptions(kind) }],
            });
          });
    this.#geometries.set(id, mesh);
    return mesh;
  }

  /** Whether nothing of it is visible. Which of its instances are drawn is decided before the draw. */
  isSkipped(view: CameraView): boolean {
    const { count, first } = this;
    const infos = this.#internals._instanceInfo;
    return count > 0 && infos.every(({ active, visible }, number) => !active || !visible || (number < count && view.hides(first + number)));
  }

  override dispose(): void {
    super.dispose();
    delete (this.#internals as { _updateDrawParameters?: unknown })._updateDrawParameters;
    this.#internals._visibilityChanged = true;
  }
}
