/**
 * Scenes from files, with the rooms, portals and mirrors that they describe.
 *
 * @see SceneFile
 */
import * as files from '../wasm/files.js';
import { checkLook, checkOptions, checkViewerOptions, depths, type LookOptions, type ViewerOptions, tightnesses } from './index.js';
import { Loader, type LoadOptions } from './load.js';

const loader = new Loader(files, {
  simd: new URL('../wasm/files_bg.wasm', import.meta.url),
  plain: new URL('../wasm/files_plain_bg.wasm', import.meta.url),
});

/** Loads the module, once. It is another than that of `enfilade`, and has all of it. */
export function loadFiles(options: LoadOptions = {}): Promise<void> {
  return loader.load(options);
}

/** Options of `SceneFile`. */
export interface SceneFileOptions {
  /** Whether to read the file as one room, without portals. Default `false`. */
  flat?: boolean;
  /** Most memory that reading may take, in bytes. Default 10^9. */
  limitBytes?: number;
}

/** A mesh of a file. */
export interface FileMesh {
  /** x, y, z of each vertex. */
  positions: Float32Array;
  /** Three vertices per triangle. */
  indices: Uint32Array;
  /** Parts, each with a number of `SceneFile.materials`. */
  groups: { start: number; count: number; material: number }[];
}

/** A material of a file. */
export interface FileMaterial {
  /** Red, green and blue, linear, 0 to 1. */
  color: [number, number, number];
  /** 1 if opaque. */
  opacity: number;
  isDoubleSided: boolean;
}

/** An object of a file. Its key is its number among `SceneFile.items`. */
export interface FileItem {
  name: string;
  /** Number of its sector: a room. */
  sector: number;
  /** Number of its mesh. */
  mesh: number;
  /** 16 numbers: the columns of the matrix from its space to that of its sector. */
  transform: Float32Array;
}

/** A camera of a file. */
export interface FileCamera {
  eye: [number, number, number];
  toward: [number, number, number];
  up: [number, number, number];
  /** Vertical field of view, in radians. */
  fovY: number;
}

/** A scene that was read from the bytes of a `.glb`, `.obj` or `.bsp` file. */
export class SceneFile {
  #file: files.SceneFile;
  /** Names of the sectors: rooms, or one for all. */
  readonly sectors: string[];
  /** What was strange in the file. */
  readonly warnings: string[];
  readonly items: FileItem[];
  readonly materials: FileMaterial[];
  readonly cameras: FileCamera[];

  /** @throws an `Error` that names the broken rule and its place in the file. */
  constructor(bytes: Uint8Array | ArrayBuffer, { flat = false, limitBytes = 1e9 }: SceneFileOptions = {}) {
    const file = new loader.glue.SceneFile(bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes), flat, limitBytes);
    this.#file = file;
    this.sectors = file.sectorNames;
    this.warnings = file.warnings;
    const [names, sectors, meshes, transforms] = [file.itemNames, file.itemSectors, file.itemMeshes, file.itemTransforms];
    this.items = names.map((name, key) => ({
      name,
      sector: sectors[key],
      mesh: meshes[key],
      transform: transforms.subarray(16 * key, 16 * key + 16),
    }));
    this.materials = chunks(file.materials, 5).map(([r, g, b, opacity, sides]) => ({
      color: [r, g, b],
      opacity,
      isDoubleSided: sides === 1,
    }));
    this.cameras = chunks(file.cameras, 10).map((numbers) => ({
      eye: triple(numbers, 0),
      toward: triple(numbers, 3),
      up: triple(numbers, 6),
      fovY: numbers[9],
    }));
  }

  get meshCount(): number {
    return this.#file.meshCount;
  }

  get triangleCount(): number {
    return this.#file.triangleCount;
  }

  /** Returns a mesh by its number, to draw it. */
  mesh(number: number): FileMesh {
    const groups = chunks(this.#file.meshGroups(number), 3).map(([start, count, material]) => ({ start, count, material }));
    return { positions: this.#file.meshPositions(number), indices: this.#file.meshIndices(number), groups };
  }

  /** Creates a camera of this scene. */
  createViewer(options: ViewerOptions = {}): FileViewer {
    checkOptions('createViewer', options, ['tightness', 'samples', 'growthPx']);
    checkViewerOptions(options);
    const { tightness = 'boxes', samples = 1, growthPx = 1 } = options;
    return new FileViewer(this.#file, new loader.glue.Viewer(tightnesses[tightness], growthPx, samples));
  }

  /** Frees the memory. Do not use it, or its viewers, afterwards. */
  dispose(): void {
    this.#file.free();
  }
}

/** A camera in a `SceneFile`, and what it saw last. */
export class FileViewer {
  #file: files.SceneFile;
  #viewer: files.Viewer;

  /** @internal */
  constructor(file: files.SceneFile, viewer: files.Viewer) {
    this.#file = file;
    this.#viewer = viewer;
  }

  /** Determines what is visible, through portals too: as `Viewer.look`. The camera is in the space of the sector that its position is in. */
  look(viewMatrix: ArrayLike<number>, projectionMatrix: ArrayLike<number>, options: LookOptions): void {
    const { width, height, depth = '-1..1', layers = 0xffffffff } = checkLook(options);
    const [view, projection] = [viewMatrix, projectionMatrix].map((matrix) => Float64Array.from(matrix));
    this.#file.look(this.#viewer, view, projection, depths[depth], width, height, layers >>> 0);
  }

  /** Determines what is visible from a camera such as those of the file. */
  lookFrom({ eye, toward, up, fovY }: FileCamera, { width, height, layers = 0xffffffff }: Omit<LookOptions, 'depth'>): void {
    this.#file.lookFrom(this.#viewer, Float64Array.of(...eye, ...toward, ...up, fovY), width, height, layers >>> 0);
  }

  /**
   * Whether the last look followed every visible portal; if not, all objects count as visible. A look follows 1,024 passages:
   * enough for all but mirrors that face each other.
   */
  get isComplete(): boolean {
    return this.#viewer.isComplete;
  }

  /** Keys of the visible objects, ascending. A view of the module's memory: read it before the next call. */
  get visible(): Uint32Array {
    return loader.words(this.#viewer.listsAddress, this.#viewer.visibleCount);
  }

  /** Frees the memory. Do not use it afterwards. */
  dispose(): void {
    this.#viewer.free();
  }
}

function chunks(numbers: ArrayLike<number>, size: number): number[][] {
  const count = Math.floor(numbers.length / size);
  return Array.from({ length: count }, (_, chunk) => Array.from({ length: size }, (_, part) => numbers[chunk * size + part]));
}

function triple(numbers: number[], first: number): [number, number, number] {
  return [numbers[first], numbers[first + 1], numbers[first + 2]];
}
