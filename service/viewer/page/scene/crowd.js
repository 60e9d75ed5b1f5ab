import {
  BufferAttribute, Color, InstancedBufferAttribute, InstancedBufferGeometry, Matrix4, MeshDepthMaterial, MeshStandardMaterial, RGBADepthPacking,
  SkinnedMesh, Sphere,
} from '../vendor/three.js';
import { formsOf } from './forms.js';
import { Joints } from './joints.js';

/** @import { Material } from '../vendor/three.js' */
/** @import { Pose, Rig } from '../vendor/motionsplice.js' */

/** Many bodies of one rig, in one draw call. */
export class Crowd {
  object;
  #rig;
  #joints;
  #positions;

  /**
   * @param {Rig} rig
   * @param {string[]} colours of each body
   */
  constructor(rig, colours) {
    const { anatomy, mannequin } = formsOf(rig);
    this.#rig = rig;
    this.#joints = new Joints(anatomy.places, colours.length);
    this.#positions = new Float32Array(3 * rig.joints.length);
    const geometry = new InstancedBufferGeometry();
    geometry.instanceCount = colours.length;
    geometry.setIndex(mannequin.attributes.index);
    for (const name of /** @type {const} */ (['position', 'normal', 'skinIndex', 'skinWeight'])) geometry.setAttribute(name, mannequin.attributes[name]);
    geometry.setAttribute('shade', new BufferAttribute(Float32Array.from(mannequin.shape.shades), 1));
    geometry.setAttribute('tint', new InstancedBufferAttribute(Float32Array.from(colours.flatMap((colour) => new Color(colour).toArray())), 3));
    const count = rig.joints.length;
    this.object = new SkinnedMesh(geometry, ofMany(new MeshStandardMaterial({ vertexColors: true, roughness: 0.72 }), count));
    this.object.customDepthMaterial = ofMany(new MeshDepthMaterial({ depthPacking: RGBADepthPacking }), count);
    this.object.bind(this.#joints, new Matrix4());
    this.object.bindMode = 'detached';
    this.object.castShadow = true;
    this.object.frustumCulled = false;
    this.object.boundingSphere = new Sphere(); // else three computes it from bones, which do not exist
  }

  /**
   * Shows a pose of one body.
   *
   * @param {number} body
   * @param {Pose} pose with rotations
   * @param {ArrayLike<number>} offset metres, [3]
   */
  set(body, pose, offset) {
    const turns = this.#rig.worldPositions(pose.root, /** @type {Float32Array} */ (pose.rotations), this.#positions);
    this.#joints.set(body, this.#positions, turns, offset);
  }

  dispose() {
    this.object.removeFromParent();
    this.object.geometry.dispose();
    this.object.material.dispose();
    this.object.customDepthMaterial?.dispose();
    this.#joints.dispose();
  }
}

/**
 * Makes a material read the joints and the colour of each instance.
 *
 * @template {Material} T
 * @param {T} material
 * @param {number} joints of a body
 */
function ofMany(material, joints) {
  material.customProgramCacheKey = () => `crowd ${joints}`;
  material.onBeforeCompile = (shader) => {
    const slots = ['x', 'y', 'z', 'w'].map((slot) => `mat4 boneMat${slot.toUpperCase()} = getBoneMatrix(skinIndex.${slot} + first);`).join('\n');
    shader.vertexShader = `attribute float shade;\nattribute vec3 tint;\n${shader.vertexShader}`
      .replace('#include <skinbase_vertex>', `float first = float(gl_InstanceID * ${joints});\n${slots}`)
      .replace('#include <color_vertex>', 'vColor.rgb = tint * (1.0 - abs(shade)) + max(shade, 0.0);');
  };
  return material;
}
