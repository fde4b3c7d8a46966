/**
 * Occlusion culling for three.js, on `WebGLRenderer` and `WebGPURenderer`.
 *
 * @see EnfiladeCuller
 */
export { EnfiladeCuller, type CullerOptions, type CullerStats, type SizedRenderer } from './three/culler.js';
export type { AddOptions } from './three/entry.js';
export { CullerOverlay } from './three/overlay.js';
export type { LoadOptions, ViewerOptions, WasmSource } from './index.js';
