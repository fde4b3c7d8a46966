import type { BatchedMesh, BufferGeometry, Camera, Frustum, Mesh } from 'three';

/** Says whether an object need not be drawn with a frustum. */
export type Skips = (frustum: Frustum) => boolean;

/** Says which instances of a batch a camera does not see; `undefined` if that is not known. */
export type Hidden = (camera: Camera) => ((instance: number) => boolean) | undefined;

/** What is called in place of a method of an object, for all cullers that know it: they may go in any order. */
interface Hook<T> {
  all: Set<T>;
  undo(): void;
}

const meshes = new WeakMap<Mesh, Hook<Skips>>();
const batches = new WeakMap<BatchedMesh, Hook<Hidden>>();

function add<K extends Mesh, T>(hooks: WeakMap<K, Hook<T>>, object: K, one: T, make: (all: Set<T>) => () => void): () => void {
  let hook = hooks.get(object);
  if (hook === undefined) {
    const all = new Set<T>();
    hook = { all, undo: make(all) };
    hooks.set(object, hook);
  }
  const { all, undo } = hook;
  all.add(one);
  return () => {
    if (all.delete(one) && all.size === 0) {
      undo();
      hooks.delete(object);
    }
  };
}

/** Lets a renderer skip an object if `skips` says so. Returns what undoes it. */
export function hookMesh(object: Mesh, skips: Skips): () => void {
  return add(meshes, object, skips, (all) => {
    const hadOwn = Object.hasOwn(object, 'intersectsFrustum');
    const before = object.intersectsFrustum;
    object.intersectsFrustum = (frustum: Frustum) => {
      for (const one of all) {
        if (one(frustum)) {
          return false;
        }
      }
      return before.call(object, frustum);
    };
    return () => {
      if (hadOwn) {
        object.intersectsFrustum = before;
      } else {
        delete (object as { intersectsFrustum?: unknown }).intersectsFrustum;
      }
    };
  });
}

/** What three.js 0.187 keeps for each instance of a batch, and offers no other way to read at once. */
export interface BatchInternals {
  _instanceInfo: { visible: boolean; active: boolean; geometryIndex: number }[];
  _matricesTexture: { version: number; image: { data: Float32Array } };
  _visibilityChanged: boolean;
  _updateDrawParameters(camera: Camera, geometry: BufferGeometry, ...others: unknown[]): void;
}

/** Lets a renderer skip instances of a batch. Returns what undoes it. */
export function hookBatch(object: BatchedMesh, hidden: Hidden): () => void {
  return add(batches, object, hidden, (all) => {
    const internals = object as unknown as BatchInternals;
    const before = internals._updateDrawParameters;
    // Called before each draw, for each camera and each light. The list of draws is made of the instances that are
    // visible; those that this camera does not see are not, for as long.
    internals._updateDrawParameters = (camera, ...others) => {
      const tests = [...all].map((one) => one(camera)).filter((test) => test !== undefined);
      if (tests.length === 0) {
        before.call(object, camera, ...others);
        return;
      }
      const off = internals._instanceInfo.filter((info, number) => info.visible && tests.some((test) => test(number)));
      off.forEach((info) => (info.visible = false));
      internals._visibilityChanged = true;
      before.call(object, camera, ...others);
      off.forEach((info) => (info.visible = true));
      // Made anew for the next camera.
      internals._visibilityChanged = true;
    };
    return () => {
      delete (internals as { _updateDrawParameters?: unknown })._updateDrawParameters;
      internals._visibilityChanged = true;
    };
  });
}
