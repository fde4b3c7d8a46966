import type { BufferAttribute, BufferGeometry, InterleavedBufferAttribute, Matrix4, Mesh, SkinnedMesh } from 'three';
import type { MeshGroup, Scene } from '../index.js';
import { Draws, groupOptions } from './material.js';

type Attribute = BufferAttribute | InterleavedBufferAttribute;

/** Returns x, y, z of each vertex; `undefined` if they are not in the page's memory. */
export function positionsOf(geometry: BufferGeometry): Float32Array | undefined {
  const attribute = geometry.getAttribute('position') as Attribute | undefined;
  const array = attribute && ('data' in attribute ? attribute.data.array : attribute.array);
  if (!array || attribute.itemSize < 3 || 'isStorageBufferAttribute' in attribute) {
    return undefined;
  }
  if (!('data' in attribute) && array instanceof Float32Array && attribute.itemSize === 3) {
    return array.length === 3 * attribute.count ? array : array.subarray(0, 3 * attribute.count);
  }
  const positions = new Float32Array(3 * attribute.count);
  for (let vertex = 0; vertex < attribute.count; vertex++) {
    positions[3 * vertex] = attribute.getX(vertex);
    positions[3 * vertex + 1] = attribute.getY(vertex);
    positions[3 * vertex + 2] = attribute.getZ(vertex);
  }
  return positions;
}

/** What the triangles of a geometry are made from. */
interface Sources {
  parts: unknown[];
  version: number;
}

const sources = new WeakMap<BufferGeometry, Sources>();
let versions = 0;

/** Number that changes whenever a geometry does: other attributes, other contents (by `needsUpdate`) or other groups. */
export function versionOf(geometry: BufferGeometry): number {
  const { index, groups } = geometry;
  const position = geometry.attributes.position as Attribute | undefined;
  const contents = position && ('data' in position ? position.data.version : position.version);
  let known = sources.get(geometry);
  if (known === undefined) {
    known = { parts: [], version: 0 };
    sources.set(geometry, known);
  }
  const { parts } = known;
  let isSame = parts.length === 4 + 3 * groups.length;
  isSame &&= parts[0] === position && parts[1] === contents && parts[2] === index && parts[3] === index?.version;
  for (let number = 0; isSame && number < groups.length; number++) {
    const { start, count, materialIndex } = groups[number];
    const first = 4 + 3 * number;
    isSame = parts[first] === start && parts[first + 1] === count && parts[first + 2] === materialIndex;
  }
  if (!isSame) {
    const flat = groups.flatMap(({ start, count, materialIndex }) => [start, count, materialIndex]);
    known.parts = [position, contents, index, index?.version, ...flat];
    known.version = ++versions;
  }
  return known.version;
}

/** Returns the parts of a geometry that are drawn, with what `Materials.of` returned for its material or each of several. */
export function groupsOf(geometry: BufferGeometry, kinds: number | number[]): MeshGroup[] {
  const { start, count } = geometry.drawRange;
  const all = geometry.index?.count ?? geometry.getAttribute('position').count;
  const end = Math.min(all, start + count);
  const groups: MeshGroup[] = [];
  const add = (from: number, to: number, kind: number | undefined) => {
    const length = to - from - ((to - from) % 3);
    if (length > 0 && kind !== undefined && !(kind & Draws.Nothing)) {
      groups.push({ start: from, count: length, ...groupOptions(kind) });
    }
  };
  if (typeof kinds === 'number') {
    add(start, end, kinds);
    return groups;
  }
  for (const { start: from, count: length, materialIndex = 0 } of geometry.groups) {
    add(Math.max(start, from), Math.min(end, from + length), kinds[materialIndex]);
  }
  return groups;
}

/** Meshes in the scene, shared by objects with the same geometry and materials of the same kind. */
export class Meshes {
  #scene: Scene;
  #of = new WeakMap<BufferGeometry, Map<string, { mesh: number; users: number }>>();
  /** A box from 0 to 1 on each axis. */
  readonly unitBox: number;

  constructor(scene: Scene) {
    this.#scene = scene;
    this.unitBox = scene.addBox([0, 0, 0], [1, 1, 1]);
  }

  /** Returns a mesh for `name`, built if no object uses it yet. Throws if the scene refuses it. */
  take(geometry: BufferGeometry, name: string, build: () => number): number {
    let named = this.#of.get(geometry);
    if (named === undefined) {
      named = new Map();
      this.#of.set(geometry, named);
    }
    const known = named.get(name);
    if (known !== undefined) {
      known.users++;
      return known.mesh;
    }
    const mesh = build();
    named.set(name, { mesh, users: 1 });
    return mesh;
  }

  /** Gives back a mesh that was taken. */
  giveBack(geometry: BufferGeometry, name: string): void {
    const named = this.#of.get(geometry);
    const known = named?.get(name);
    if (known !== undefined && --known.users === 0) {
      named!.delete(name);
      this.#scene.removeMesh(known.mesh);
    }
  }
}

/** A box in any space, as its minimum and maximum. */
export class Box {
  readonly min = [Infinity, Infinity, Infinity];
  readonly max = [-Infinity, -Infinity, -Infinity];

  get isEmpty(): boolean {
    return !(this.min[0] <= this.max[0]);
  }

  clear(): void {
    this.min.fill(Infinity);
    this.max.fill(-Infinity);
  }

  add(x: number, y: number, z: number): void {
    const { min, max } = this;
    min[0] = Math.min(min[0], x);
    min[1] = Math.min(min[1], y);
    min[2] = Math.min(min[2], z);
    max[0] = Math.max(max[0], x);
    max[1] = Math.max(max[1], y);
    max[2] = Math.max(max[2], z);
  }

  /** Adds a box moved by a matrix. */
  addMoved(box: Box, matrix: Matrix4): void {
    const e = matrix.elements;
    for (let row = 0; row < 3; row++) {
      let low = e[12 + row];
      let high = low;
      for (let axis = 0; axis < 3; axis++) {
        const [a, b] = [e[4 * axis + row] * box.min[axis], e[4 * axis + row] * box.max[axis]];
        low += Math.min(a, b);
        high += Math.max(a, b);
      }
      this.min[row] = Math.min(this.min[row], low);
      this.max[row] = Math.max(this.max[row], high);
    }
  }

  /** Writes the matrix that moves the box from 0 to 1 to this one, a little larger than it is, for rounding. */
  toMatrix(elements: number[]): void {
    elements.fill(0);
    for (let axis = 0; axis < 3; axis++) {
      const size = this.max[axis] - this.min[axis];
      const more = 1e-3 * size + 1e-6 * Math.abs(this.max[axis] + this.min[axis]);
      elements[5 * axis] = size + 2 * more;
      elements[12 + axis] = this.min[axis] - more;
    }
    elements[15] = 1;
  }
}

function boxOf(attribute: Attribute): Box {
  const box = new Box();
  for (let vertex = 0; vertex < attribute.count; vertex++) {
    box.add(attribute.getX(vertex), attribute.getY(vertex), attribute.getZ(vertex));
  }
  return box;
}

/** Boxes around what skinning and morphing can make of a mesh. Skinned positions are weighted means of what each bone does. */
export class Poses {
  #mesh: Mesh;
  #geometry: BufferGeometry;
  #version: number;
  /** What each bone moves, in the space of the bone. */
  #bones: Box[] = [];
  #base = new Box();
  #targets: Box[] = [];
  #local = new Box();

  constructor(mesh: Mesh) {
    this.#mesh = mesh;
    this.#geometry = mesh.geometry;
    this.#version = versionOf(mesh.geometry);
    const position = this.#geometry.getAttribute('position') as Attribute;
    if (isSkinned(mesh)) {
      this.#addBones(mesh, position);
      return;
    }
    this.#base = boxOf(position);
    this.#targets = (this.#geometry.morphAttributes.position ?? []).map((target) => boxOf(target as Attribute));
  }

  isOf(mesh: Mesh): boolean {
    return mesh.geometry === this.#geometry && versionOf(mesh.geometry) === this.#version;
  }

  #addBones(mesh: SkinnedMesh, position: Attribute): void {
    const indices = this.#geometry.getAttribute('skinIndex') as Attribute;
    const weights = this.#geometry.getAttribute('skinWeight') as Attribute;
    const toBone = mesh.skeleton.boneInverses.map((inverse) => inverse.clone().multiply(mesh.bindMatrix).elements);
    this.#bones = toBone.map(() => new Box());
    for (let vertex = 0; vertex < position.count; vertex++) {
      const [x, y, z] = [position.getX(vertex), position.getY(vertex), position.getZ(vertex)];
      for (let number = 0; number < 4; number++) {
        const bone = indices.getComponent(vertex, number);
        const e = toBone[bone];
        if (e !== undefined && weights.getComponent(vertex, number) > 0) {
          this.#bones[bone].add(
            e[0] * x + e[4] * y + e[8] * z + e[12],
            e[1] * x + e[5] * y + e[9] * z + e[13],
            e[2] * x + e[6] * y + e[10] * z + e[14],
          );
        }
      }
    }
  }

  /** Sets `box` to the bounds in the world of the pose that will be drawn. */
  bounds(box: Box, scratch: Matrix4): void {
    box.clear();
    const mesh = this.#mesh;
    if (isSkinned(mesh)) {
      const { bones } = mesh.skeleton;
      for (let number = 0; number < this.#bones.length; number++) {
        if (!this.#bones[number].isEmpty && bones[number] !== undefined) {
          // In attached mode the product of the first two is the identity.
          scratch.multiplyMatrices(mesh.matrixWorld, mesh.bindMatrixInverse).multiply(bones[number].matrixWorld);
          box.addMoved(this.#bones[number], scratch);
        }
      }
      return;
    }
    const relative = this.#geometry.morphTargetsRelative;
    const influences = mesh.morphTargetInfluences ?? [];
    const total = influences.reduce((sum, influence) => sum + influence, 0);
    const local = this.#local;
    for (let axis = 0; axis < 3; axis++) {
      const base = relative ? 1 : 1 - total;
      const ends = [base * this.#base.min[axis], base * this.#base.max[axis]];
      local.min[axis] = Math.min(...ends);
      local.max[axis] = Math.max(...ends);
      this.#targets.forEach((target, number) => {
        const ends = [target.min[axis], target.max[axis]].map((end) => end * (influences[number] ?? 0));
        local.min[axis] += Math.min(...ends);
        local.max[axis] += Math.max(...ends);
      });
    }
    box.addMoved(local, mesh.matrixWorld);
  }
}

export function isSkinned(mesh: Mesh): mesh is SkinnedMesh {
  return (mesh as { isSkinnedMesh?: boolean }).isSkinnedMesh === true;
}

export function isMorphed(mesh: Mesh): boolean {
  return (mesh.geometry.morphAttributes.position?.length ?? 0) > 0;
}
