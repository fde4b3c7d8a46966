/** Where a `.wasm` file comes from: an address, a response, its bytes, or what `WebAssembly.compile` made of them. */
export type WasmSource = string | URL | Request | Response | BufferSource | WebAssembly.Module;

/** Options of `load`. */
export interface LoadOptions {
  /**
   * The `.wasm` file, if your bundler or server does not serve it beside the JavaScript: `wasm/core_bg.wasm` of this
   * package, or `wasm/core_plain_bg.wasm` without SIMD.
   */
  wasm?: WasmSource | Promise<WasmSource>;
  /** Whether to use the build with SIMD. Default: if the browser can. */
  simd?: boolean;
}

/** The JavaScript side of a `.wasm` file, as wasm-bindgen writes it. */
export interface Glue {
  default(source: { module_or_path: WasmSource | Promise<WasmSource> }): Promise<{ memory: WebAssembly.Memory }>;
}

/** Whether this browser has WebAssembly SIMD. All have since 2023: Chrome 91, Firefox 89, Safari 16.4. */
export function hasSimd(): boolean {
  // (module (func (result v128) i32.const 0 i8x16.splat))
  return WebAssembly.validate(
    new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 8, 1, 6, 0, 65, 0, 253, 15, 11]),
  );
}

/** Reads a file, which `fetch` of Node.js does not. Bundlers must not look for its module. */
async function readInNode(address: URL): Promise<WasmSource> {
  const name = 'node:fs/promises';
  const { readFile } = (await import(/* @vite-ignore */ /* webpackIgnore: true */ name)) as { readFile(path: URL): Promise<Uint8Array<ArrayBuffer>> };
  return readFile(address);
}

/** Loads one of the two builds of a module, once. */
export class Loader<G extends Glue> {
  #glue: G;
  #addresses: { simd: URL; plain: URL };
  #loading: Promise<void> | undefined;
  #memory: WebAssembly.Memory | undefined;

  constructor(glue: G, addresses: { simd: URL; plain: URL }) {
    this.#glue = glue;
    this.#addresses = addresses;
  }

  load({ wasm, simd = hasSimd() }: LoadOptions): Promise<void> {
    const source = wasm ?? (simd ? this.#addresses.simd : this.#addresses.plain);
    this.#loading ??= this.#glue.default({ module_or_path: source instanceof URL && source.protocol === 'file:' ? readInNode(source) : source }).then(
      ({ memory }) => {
        this.#memory = memory;
      },
      (why: unknown) => {
        this.#loading = undefined;
        throw new Error(`enfilade: the .wasm file cannot be loaded from ${String(source)}; see LoadOptions.wasm`, { cause: why });
      },
    );
    return this.#loading;
  }

  get glue(): G {
    if (this.#memory === undefined) {
      throw new Error('enfilade: call `await load()` first');
    }
    return this.#glue;
  }

  /** Numbers in the memory of the module. */
  words(address: number, length: number): Uint32Array {
    return new Uint32Array(this.#memory!.buffer, address, length);
  }
}
