import { DynamicDrawUsage, InstancedBufferAttribute, InstancedMesh, Matrix4, type Frustum } from 'three';
import { Draws } from './material.js';
import { isMorphed, versionOf } from './geometry.js';
import { Entry, displacement, sphereMatrix } from './entry.js';
import type { CameraView } from './view.js';

const scratch = new Matrix4();
const instance = new Matrix4();
const elements = new Array<number>(16).fill(0);

/**
 * The visible instances of an object, drawn in its place for one camera.
 *
 * A child of the object, since the object itself must keep all instances for shadows and other cameras.
 */
class VisibleInstances extends InstancedMesh {
  constructor(source: InstancedMesh) {
    super(source.geometry, source.material, source.instanceMatrix.count);
    this.name = 'enfilade: visible instances';
    this.userData.enfilade = true;
    this.matrixAutoUpdate = false;
    this.castShadow = false;
    this.instanceMatrix.setUsage(DynamicDrawUsage);
    if (source.instanceColor) {
      const { array, itemSize, normalized } = source.instanceColor;
      this.instanceColor = new InstancedBufferAttribute(array.slice(), itemSize, normalized).setUsage(DynamicDrawUsage);
    }
    if (Object.hasOwn(source, 'onBeforeRender')) {
      this.onBeforeRender = source.onBeforeRender;
    }
    if (Object.hasOwn(source, 'onAfterRender')) {
      this.onAfterRender = source.onAfterRender;
    }
    source.add(this);
  }

  override raycast(): void {}

  /** Takes over those instances of the object that `sees` returns `true` for. */
  fill(source: InstancedMesh, sees: (instance: number) => boolean): void {
    this.material = source.material;
    this.layers.mask = source.layers.mask;
    this.renderOrder = source.renderOrder;
    this.receiveShadow = source.receiveShadow;
    this.boundingSphere = source.boundingSphere;
    const [from, to] = [source.instanceMatrix.array, this.instanceMatrix.array];
    const [fromColor, toColor] = [source.instanceColor, this.instanceColor];
    let count = 0;
    for (let number = 0; number < source.count; number++) {
      if (!sees(number)) {
        continue;
      }
      for (let element = 0; element < 16; element++) {
        to[16 * count + element] = from[16 * number + element];
      }
      if (fromColor && toColor) {
        const size = fromColor.itemSize;
        for (let element = 0; element < size; element++) {
          toColor.array[size * count + element] = fromColor.array[size * number + element];
        }
      }
      count++;
    }
    this.count = count;
    for (const [attribute, size] of [[this.instanceMatrix, 16] as const, [toColor, toColor?.itemSize ?? 0] as const]) {
      if (attribute) {
        attribute.clearUpdateRanges();
        attribute.addUpdateRange(0, Math.max(count, 1) * size);
        attribute.needsUpdate = true;
      }
    }
  }
}

/** Instances of a mesh, each culled by itself. */
export class InstancedEntry extends Entry<InstancedMesh> {
  #mesh: number | undefined;
  #state: unknown[] = [];
  #visible = new Map<CameraView, VisibleInstances>();
  /** Whether its instances are culled as a whole, since the culler cannot draw some of them. */
  #isWhole = false;
  /** Whether the scene has its present instances. */
  #isIn = false;

  refresh(): void {
    const { object, world, isOccluder } = this;
    const { geometry } = object;
    const draws = this.draws();
    if (draws & Draws.Through || isMorphed(object) || 'isSkinnedMesh' in object) {
      this.leave();
      return;
    }
    if (draws & Draws.Nothing) {
      this.hide();
      return;
    }
    const kinds = this.kinds();
    const layers = object.layers.mask >>> 0;
    const { version } = object.instanceMatrix;
    const { start, count } = geometry.drawRange;
    const meshState = [geometry, kinds, versionOf(geometry), start, count];
    const state = [...meshState, layers, isOccluder, version, object.instanceMatrix, object.count];
    const isSame = this.#isIn && state.every((value, number) => value === this.#state[number]);
    if (isSame && world.slots.isAt(this.first + this.count - 1, object.matrixWorld.elements, layers)) {
      return;
    }
    const isSameMesh = meshState.every((value, number) => value === this.#state[number]);
    this.#state = state;
    const isBox = (draws & Draws.Moves) !== 0;
    if (!isSameMesh) {
      this.retake(() => (this.#mesh = isBox ? world.meshes.unitBox : this.takeMesh(geometry, kinds)));
      this.#isWhole = Object.values(geometry.attributes).some((attribute) => 'isInstancedBufferAttribute' in attribute);
    }
    if (this.#mesh === undefined || object.count === 0) {
      this.leave();
      return;
    }
    // One more, without a mesh to see: it keeps the matrix of the object.
    this.reserve(object.count + 1);
    const grown = isBox ? displacement(this.material!) : 0;
    for (let number = 0; number < object.count; number++) {
      instance.fromArray(object.instanceMatrix.array, 16 * number);
      // three.js turns the winding by the transform of the object alone, so it draws a mirrored instance inside out.
      const isInsideOut = instance.determinant() < 0;
      instance.premultiply(object.matrixWorld);
      if (isBox || isInsideOut) {
        sphereMatrix(object, instance, grown, elements);
        world.slots.put(this.first + number, world.meshes.unitBox, elements, false, layers);
      } else {
        world.slots.put(this.first + number, this.#mesh, instance.elements, isOccluder, layers);
      }
    }
    world.slots.remember(this.first + object.count, object.matrixWorld.elements, layers);
    this.#isIn = true;
  }

  override hide(): void {
    super.hide();
    this.#isIn = false;
  }

  protected override leave(): void {
    super.leave();
    this.#isIn = false;
  }

  override seen(view: CameraView): void {
    const { object, count } = this;
    let isAnySeen = false;
    let isAnyHidden = false;
    for (let slot = this.first; slot < this.first + count - 1; slot++) {
      isAnySeen ||= view.sees(slot);
      isAnyHidden ||= view.hides(slot);
    }
    let visible = this.#visible.get(view);
    if (this.#isWhole || count === 0 || !isAnyHidden || !isAnySeen) {
      if (visible) {
        visible.count = 0;
      }
      return;
    }
    if (visible && (visible.geometry !== object.geometry || visible.instanceMatrix.count < object.count || !visible.instanceColor !== !object.instanceColor)) {
      this.#discard(visible);
      visible = undefined;
    }
    if (!visible) {
      visible = new VisibleInstances(object);
      visible.intersectsFrustum = (frustum: Frustum) =>
        this.world.isOn(view, frustum) && this.#standsIn(view) && frustum.intersectsObject(object);
      this.#visible.set(view, visible);
    }
    visible.fill(object, (number) => view.sees(this.first + number));
  }

  isSkipped(view: CameraView): boolean {
    if (this.#standsIn(view)) {
      return true;
    }
    for (let slot = this.first; slot < this.first + this.count - 1; slot++) {
      if (!view.hides(slot)) {
        return false;
      }
    }
    return this.count > 0 && (!this.world.compares || this.#isAsLookedAt());
  }

  /** Whether the visible instances are drawn in place of the object. */
  #standsIn(view: CameraView): boolean {
    const visible = this.#visible.get(view);
    return visible !== undefined && visible.count > 0 && (!this.world.compares || this.#isAsLookedAt());
  }

  #isAsLookedAt(): boolean {
    const { object, world } = this;
    return (
      object.count === this.count - 1 &&
      object.instanceMatrix.version === this.#state[7] &&
      world.slots.isAt(this.first + this.count - 1, object.matrixWorld.elements, object.layers.mask >>> 0)
    );
  }

  /** Forgets what was made for a camera. */
  override forgetView(view: CameraView): void {
    const visible = this.#visible.get(view);
    if (visible) {
      this.#discard(visible);
      this.#visible.delete(view);
    }
  }

  #discard(visible: VisibleInstances): void {
    visible.removeFromParent();
    visible.dispose();
  }

  override dispose(): void {
    super.dispose();
    this.#visible.forEach((visible) => this.#discard(visible));
  }
}
