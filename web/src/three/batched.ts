import { Matrix4, Sphere, type BatchedMesh } from 'three';
import { Draws, groupOptions } from './material.js';
import { positionsOf, versionOf } from './geometry.js';
import { Entry, type AddOptions, type World, displacement } from './entry.js';
import { type BatchInternals, hookBatch } from './hooks.js';
import type { CameraView } from './view.js';

const matrix = new Matrix4();
const sphere = new Sphere();

/** The objects of a batch, each culled by itself. */
export class BatchedEntry extends Entry<BatchedMesh> {
  #geometries = new Map<number, number | undefined>();
  #state: unknown[] = [];
  readonly #internals: BatchInternals;
  readonly #unhookBatch: () => void;

  constructor(object: BatchedMesh, options: AddOptions, world: World) {
    super(object, options, world);
    this.#internals = object as unknown as BatchInternals;
    this.#unhookBatch = hookBatch(object, (camera) => {
      const hidden = world.hiddenFor(camera);
      return hidden && ((instance) => instance < this.count && hidden(this.first + instance));
    });
  }

  refresh(): void {
    const { object, world } = this;
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
    const isBox = (draws & Draws.Moves) !== 0;
    const state = [geometry, versionOf(geometry), kinds];
    if (!state.every((value, number) => value === this.#state[number])) {
      this.#geometries.clear();
      this.#state = state;
      // Others are taken where they are needed; these stay until then.
      this.retake(() => infos.forEach(({ active, geometryIndex }) => active && this.#meshOf(geometryIndex, kinds, isBox)));
    }
    this.reserve(infos.length);
    const { isOccluder } = this;
    const layers = object.layers.mask >>> 0;
    const matrices = internals._matricesTexture.image.data;
    const grown = displacement(this.material!);
    infos.forEach((info, number) => {
      const slot = this.first + number;
      const mesh = info.active && info.visible ? this.#meshOf(info.geometryIndex, kinds, isBox) : undefined;
      if (mesh === undefined) {
        world.slots.drop(slot);
        return;
      }
      matrix.fromArray(matrices, 16 * number);
      // A mirrored one is drawn inside out, as mirrored instances are.
      const isBoxHere = isBox || matrix.determinant() < 0;
      matrix.premultiply(object.matrixWorld);
      if (isBoxHere) {
        object.getBoundingSphereAt(info.geometryIndex, sphere);
        const r = sphere.radius + grown;
        const { x, y, z } = sphere.center;
        matrix.multiply(new Matrix4().makeScale(2 * r, 2 * r, 2 * r).setPosition(x - r, y - r, z - r));
      }
      world.slots.put(slot, isBoxHere ? world.meshes.unitBox : mesh, matrix.elements, isOccluder && !isBoxHere, layers);
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
    this.#unhookBatch();
  }
}
