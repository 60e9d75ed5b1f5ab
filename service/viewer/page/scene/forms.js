import { BufferAttribute, BufferGeometry } from '../vendor/three.js';
import { Anatomy } from './anatomy.js';
import { mannequin } from './mannequin.js';
import { stick } from './stick.js';

/** @import { Rig } from '../vendor/motionsplice.js' */
/** @import { Shape } from './shape.js' */

/** @typedef {'mannequin' | 'stick'} Style */
/** @typedef {{ shape: Shape, geometry: BufferGeometry }} Form */

/** @type {WeakMap<Rig, Forms>} */
const FORMS = new WeakMap();

/** The surfaces of a rig, which its bodies share. @param {Rig} rig */
export function formsOf(rig) {
  const forms = FORMS.get(rig) ?? new Forms(rig);
  FORMS.set(rig, forms);
  return forms;
}

/** Surfaces, each computed when it is first shown. */
class Forms {
  /** @type {Partial<Record<Style, Form>>} */
  #known = {};

  /** @param {Rig} rig */
  constructor(rig) {
    this.anatomy = new Anatomy(rig);
  }

  /**
   * @param {Style} style
   * @returns {Form}
   */
  of(style) {
    return (this.#known[style] ??= formOf(style === 'stick' ? stick(this.anatomy) : mannequin(this.anatomy)));
  }
}

/** @param {Shape} shape */
function formOf(shape) {
  return { shape, geometry: geometryOf(shape) };
}

/**
 * Returns a surface for the graphics card, with its normals and the joints that move it.
 *
 * @param {Shape} shape
 */
export function geometryOf(shape) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(Float32Array.from(shape.positions), 3));
  geometry.setAttribute('skinIndex', new BufferAttribute(Uint16Array.from(shape.skinIndices), 4));
  geometry.setAttribute('skinWeight', new BufferAttribute(Float32Array.from(shape.skinWeights), 4));
  geometry.setIndex(shape.indices);
  geometry.computeVertexNormals();
  return geometry;
}
