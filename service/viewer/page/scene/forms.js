import { BufferAttribute, BufferGeometry } from '../vendor/three.js';
import { Anatomy } from './anatomy.js';
import { mannequin } from './mannequin.js';
import { stick } from './stick.js';

/** @import { Rig } from '../vendor/motionsplice.js' */
/** @import { Shape } from './shape.js' */

/** @typedef {'mannequin' | 'stick'} Style */
/** @typedef {{ shape: Shape, attributes: ReturnType<typeof attributesOf> }} Form */

/** @type {WeakMap<Rig, { anatomy: Anatomy, mannequin: Form, stick: Form }>} */
const FORMS = new WeakMap();

/** The surfaces of a rig, which its bodies share. @param {Rig} rig */
export function formsOf(rig) {
  let forms = FORMS.get(rig);
  if (!forms) {
    const anatomy = new Anatomy(rig);
    const form = (/** @type {Shape} */ shape) => ({ shape, attributes: attributesOf(shape) });
    forms = { anatomy, mannequin: form(mannequin(anatomy)), stick: form(stick(anatomy)) };
    FORMS.set(rig, forms);
  }
  return forms;
}

/** @param {Shape} shape */
function attributesOf(shape) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(Float32Array.from(shape.positions), 3));
  geometry.setIndex(shape.indices);
  geometry.computeVertexNormals();
  return {
    position: geometry.getAttribute('position'), normal: geometry.getAttribute('normal'), index: geometry.getIndex(),
    skinIndex: new BufferAttribute(Uint16Array.from(shape.skinIndices), 4), skinWeight: new BufferAttribute(Float32Array.from(shape.skinWeights), 4),
  };
}
