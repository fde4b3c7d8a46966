import { Scene, type ItemOptions } from '../index.js';

const none = -1;
const occluder = 1;

/** A growing list of 32-bit numbers. */
class Words {
  #words = new Uint32Array(64);
  length = 0;

  push(word: number): void {
    if (this.length === this.#words.length) {
      const more = new Uint32Array(2 * this.length);
      more.set(this.#words);
      this.#words = more;
    }
    this.#words[this.length++] = word;
  }

  get all(): Uint32Array {
    return this.#words.subarray(0, this.length);
  }
}

/**
 * The objects of the scene by number ("slot"), and what each was when it was handed in last: only differences are handed in
 * again, all of a frame at once.
 */
export class Slots {
  readonly scene = new Scene();
  /** Changes with every change of the scene: a camera that looked before must look again. */
  version = 0;
  /** Whether changes do not count as such: those of levels of detail, which each camera chooses for itself. */
  isQuiet = false;
  /** One bit per slot: set if its object is in the scene and drawn. */
  present = new Uint32Array(0);
  #meshes = new Int32Array(0);
  #flags = new Uint8Array(0);
  #layers = new Uint32Array(0);
  /** 16 numbers per slot. */
  #matrices = new Float64Array(0);
  #end = 0;
  #free = new Map<number, number[]>();
  #added = new Words();
  #moved = new Words();
  #changed = new Words();
  #meshed = new Words();
  #removed = new Words();

  /** Returns the first of `count` free slots in a row. */
  take(count: number): number {
    const known = this.#free.get(count)?.pop();
    if (known !== undefined) {
      return known;
    }
    const first = this.#end;
    this.#end += count;
    if (this.#end > this.#meshes.length) {
      this.#grow(Math.max(this.#end, 2 * this.#meshes.length, 1024));
    }
    return first;
  }

  /** Gives back what `take` returned, with its objects. */
  giveBack(first: number, count: number): void {
    for (let slot = first; slot < first + count; slot++) {
      this.drop(slot);
    }
    const others = this.#free.get(count);
    if (others === undefined) {
      this.#free.set(count, [first]);
    } else {
      others.push(first);
    }
  }

  #grow(length: number): void {
    const grown = <A extends { set(from: A): void }>(array: A, larger: A): A => {
      larger.set(array);
      return larger;
    };
    const before = this.#meshes.length;
    this.present = grown(this.present, new Uint32Array(Math.ceil(length / 32)));
    this.#meshes = grown(this.#meshes, new Int32Array(length)).fill(none, before);
    this.#flags = grown(this.#flags, new Uint8Array(length));
    this.#layers = grown(this.#layers, new Uint32Array(length));
    this.#matrices = grown(this.#matrices, new Float64Array(16 * length));
  }

  /** Hands in an object. With no layers it is neither visible nor hides others. */
  put(slot: number, mesh: number, matrix: ArrayLike<number>, isOccluder: boolean, layers: number): void {
    const flags = isOccluder ? occluder : 0;
    const isNew = this.#meshes[slot] === none;
    const matrices = this.#matrices;
    const first = 16 * slot;
    let hasMoved = false;
    for (let number = 0; number < 16; number++) {
      if (matrices[first + number] !== matrix[number]) {
        matrices[first + number] = matrix[number];
        hasMoved = true;
      }
    }
    const hasMesh = this.#meshes[slot] === mesh;
    const hasOptions = this.#flags[slot] === flags && this.#layers[slot] === layers;
    if (isNew) {
      this.#added.push(slot);
    } else {
      if (hasMoved) {
        this.#moved.push(slot);
      }
      if (!hasMesh) {
        this.#meshed.push(slot);
      }
      if (!hasOptions) {
        this.#changed.push(slot);
      }
    }
    if (isNew || hasMoved || !hasMesh || (!hasOptions && !this.isQuiet)) {
      this.version++;
    }
    this.#meshes[slot] = mesh;
    this.#flags[slot] = flags;
    this.#layers[slot] = layers;
    this.#mark(slot, layers !== 0);
  }

  /** Keeps an object out of sight, without forgetting it. */
  hide(slot: number): void {
    if (this.#meshes[slot] !== none && this.#layers[slot] !== 0) {
      this.#layers[slot] = 0;
      this.#changed.push(slot);
      this.version += this.isQuiet ? 0 : 1;
      this.#mark(slot, false);
    }
  }

  /** Forgets an object. */
  drop(slot: number): void {
    if (this.#meshes[slot] !== none) {
      this.#meshes[slot] = none;
      this.#removed.push(slot);
      this.version++;
      this.#mark(slot, false);
    }
  }

  #mark(slot: number, isPresent: boolean): void {
    if (isPresent) {
      this.present[slot >>> 5] |= 1 << (slot & 31);
    } else {
      this.present[slot >>> 5] &= ~(1 << (slot & 31));
    }
  }

  /** Keeps a matrix and layers in a slot without an object, for `isAt`. */
  remember(slot: number, matrix: ArrayLike<number>, layers: number): void {
    this.#matrices.set(matrix, 16 * slot);
    this.#layers[slot] = layers;
  }

  /** Sets `bits` to one bit per slot: whether its object is in the scene, drawn, and in one of some layers. */
  presentIn(layers: number, bits: Uint32Array): void {
    bits.set(this.present);
    for (let slot = 0; slot < this.#end; slot++) {
      if ((this.#layers[slot] & layers) === 0) {
        bits[slot >>> 5] &= ~(1 << (slot & 31));
      }
    }
  }

  /** Whether an object is where, and in the layers, it was handed in. */
  isAt(slot: number, matrix: ArrayLike<number>, layers: number): boolean {
    const matrices = this.#matrices;
    const first = 16 * slot;
    for (let number = 0; number < 16; number++) {
      if (matrices[first + number] !== matrix[number]) {
        return false;
      }
    }
    return this.#layers[slot] === layers;
  }

  /** 16 numbers: the matrix of an object. */
  matrixAt(slot: number): Float64Array {
    return this.#matrices.subarray(16 * slot, 16 * slot + 16);
  }

  /** Hands everything to the scene. Returns the number of objects that moved. */
  flush(): number {
    if (this.#removed.length > 0) {
      this.scene.remove(this.#removed.all);
    }
    const isThere = (slot: number) => this.#meshes[slot] !== none;
    const added = this.#added.all.filter(isThere);
    if (added.length > 0) {
      this.scene.add(added, this.#meshesOf(added), this.#matricesOf(added), this.#optionsOf(added));
    }
    const meshed = this.#meshed.all.filter(isThere);
    if (meshed.length > 0) {
      this.scene.setMeshes(meshed, this.#meshesOf(meshed));
    }
    const changed = this.#changed.all.filter(isThere);
    if (changed.length > 0) {
      this.scene.setOptions(changed, this.#optionsOf(changed));
    }
    const moved = this.#moved.all.filter(isThere);
    if (moved.length > 0) {
      this.scene.setTransforms(moved, this.#matricesOf(moved));
    }
    for (const words of [this.#removed, this.#added, this.#meshed, this.#changed, this.#moved]) {
      words.length = 0;
    }
    return moved.length;
  }

  #meshesOf(slots: Uint32Array): Uint32Array {
    return slots.map((slot) => this.#meshes[slot]);
  }

  #matricesOf(slots: Uint32Array): Float32Array {
    const matrices = new Float32Array(16 * slots.length);
    for (let number = 0; number < slots.length; number++) {
      matrices.set(this.matrixAt(slots[number]), 16 * number);
    }
    return matrices;
  }

  #optionsOf(slots: Uint32Array): ItemOptions[] {
    const options = (slot: number) => ({ occluder: this.#flags[slot] === occluder, layers: this.#layers[slot] });
    return Array.from(slots, options);
  }

  dispose(): void {
    this.scene.dispose();
  }
}
