import type { Material, Object3D, Side as ThreeSide } from 'three';
import type { MeshGroup } from '../index.js';

/** What a material means for culling. */
export const enum Draws {
  /** Opaque triangles, where the geometry says. */
  Plainly = 0,
  /** One can see through it, or it is not sure that what is behind is hidden: it hides nothing. */
  SeeThrough = 1,
  /** A shader may move its vertices: only the bounding sphere of the geometry counts, as for three.js. */
  Moves = 2,
  /** It may show in front of what is nearer: never culled. */
  Through = 4,
  /** Nothing. */
  Nothing = 8,
}

// Constants of three.js, so that this module does not import it.
const BackSide: ThreeSide = 1;
const DoubleSide: ThreeSide = 2;
const NormalBlending = 1;
const LessDepth = 2;
const LessEqualDepth = 3;

/** Nodes of a node material that move vertices. */
const movingNodes = ['vertexNode', 'positionNode', 'geometryNode'];
/** Nodes of a node material that may discard fragments, or change their depth. */
const seeThroughNodes = ['fragmentNode', 'opacityNode', 'alphaTestNode', 'maskNode', 'depthNode', 'outputNode'];

interface AnyMaterial extends Material {
  [name: string]: unknown;
}

/** Returns what a material means for culling, a combination of `Draws`. `trusted`: the page says that it occludes. */
export function drawsHow(material: Material, trusted: boolean): number {
  const any = material as AnyMaterial;
  if (!material.visible) {
    return Draws.Nothing;
  }
  let draws = Draws.Plainly;
  const depthFunc = material.depthFunc as number;
  const offset = material.polygonOffset;
  if (
    !material.depthTest ||
    (depthFunc !== LessDepth && depthFunc !== LessEqualDepth) ||
    (offset && (material.polygonOffsetFactor < 0 || material.polygonOffsetUnits < 0))
  ) {
    draws |= Draws.Through | Draws.SeeThrough;
  }
  if (trusted) {
    return draws;
  }
  if (
    any.isShaderMaterial ||
    any.isRawShaderMaterial ||
    any.displacementMap ||
    // Set by the page: that of the class is empty.
    Object.hasOwn(material, 'onBeforeCompile') ||
    (any.isNodeMaterial && movingNodes.some((node) => any[node]))
  ) {
    draws |= Draws.Moves | Draws.SeeThrough;
  }
  if (
    material.transparent ||
    material.alphaTest > 0 ||
    material.alphaHash ||
    material.alphaToCoverage ||
    !material.depthWrite ||
    !material.colorWrite ||
    material.stencilWrite ||
    (material.blending as number) > NormalBlending ||
    any.wireframe ||
    (any.transmission as number) > 0 ||
    (offset && (material.polygonOffsetFactor > 0 || material.polygonOffsetUnits > 0)) ||
    (any.isNodeMaterial && seeThroughNodes.some((node) => any[node]))
  ) {
    draws |= Draws.SeeThrough;
  }
  return draws;
}

/** Materials of a frame: what each means, found out once, since pages change materials without telling. */
export class Materials {
  #frame = 0;
  #known = new WeakMap<Material, { frame: number; draws: number; side: number }>();

  /** Begins a frame. */
  begin(): void {
    this.#frame++;
  }

  /** Returns `Draws`, with the side in the higher bits. */
  of(material: Material, trusted: boolean): number {
    if (trusted) {
      return drawsHow(material, true) | (material.side << 4);
    }
    let known = this.#known.get(material);
    if (known === undefined) {
      known = { frame: -1, draws: 0, side: 0 };
      this.#known.set(material, known);
    }
    if (known.frame !== this.#frame) {
      known.frame = this.#frame;
      known.draws = drawsHow(material, false);
      known.side = material.side;
    }
    return known.draws | (known.side << 4);
  }
}

/** Materials of an object. */
export function materialsOf(object: Object3D): Material | Material[] | undefined {
  return (object as { material?: Material | Material[] }).material;
}

/** Returns the options of a part with a material, from what `Materials.of` returned. */
export function groupOptions(draws: number): Pick<MeshGroup, 'side' | 'seeThrough'> {
  const side = draws >> 4;
  return {
    side: side === DoubleSide ? 'double' : side === BackSide ? 'back' : 'front',
    seeThrough: (draws & Draws.SeeThrough) !== 0,
  };
}
