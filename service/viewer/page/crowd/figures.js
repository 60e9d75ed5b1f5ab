import { BufferAttribute, Color, DataTexture, FloatType, InstancedMesh, Matrix4, MeshDepthMaterial, MeshStandardMaterial, RGBAFormat } from '../vendor/three.js';
import { Anatomy } from '../scene/anatomy.js';
import { geometryOf } from '../scene/forms.js';
import { mannequin } from '../scene/mannequin.js';
import { CoarseShape } from './coarse.js';
import { Bones, NUMBERS } from './bones.js';

/** @import { Pose, Rig } from '../vendor/motionsplice.js' */
/** @import { Member } from './cast.js' */

const TEXELS = NUMBERS / 4; // of a matrix
const TALLEST = 1024; // rows of the texture
const FINE = 30; // most characters that have the surface of a single one
const COLOURS = ['#e08a3c', '#6f93c4', '#7fae86', '#c9a84e', '#a98bbd', '#c77b74', '#8f9aa6', '#5fa7a7'];

// Where three.js has one skeleton for each mesh, all bodies read theirs from one texture.
const PARS = /* glsl */ `
  attribute vec4 skinIndex;
  attribute vec4 skinWeight;
  attribute float shade;
  uniform highp sampler2D joints;
  mat4 jointMatrix(float joint) {
    int columns = textureSize(joints, 0).x / (JOINTS * ${TEXELS});
    ivec2 at = ivec2(((gl_InstanceID % columns) * JOINTS + int(joint)) * ${TEXELS}, gl_InstanceID / columns);
    return transpose(mat4(texelFetch(joints, at, 0), texelFetch(joints, at + ivec2(1, 0), 0), texelFetch(joints, at + ivec2(2, 0), 0), vec4(0.0, 0.0, 0.0, 1.0)));
  }`;
const BASE = /* glsl */ `
  mat4 jointed = skinWeight.x * jointMatrix(skinIndex.x);
  if (skinWeight.y > 0.0) jointed += skinWeight.y * jointMatrix(skinIndex.y);
  if (skinWeight.z > 0.0) jointed += skinWeight.z * jointMatrix(skinIndex.z);
  if (skinWeight.w > 0.0) jointed += skinWeight.w * jointMatrix(skinIndex.w);`;

/** The bodies of a crowd, in one draw call. */
export class Figures {
  object;
  #bones;
  #values;
  #texture;
  #stride;

  /**
   * @param {Rig} rig
   * @param {number} count
   */
  constructor(rig, count) {
    this.rig = rig;
    const anatomy = new Anatomy(rig);
    const joints = rig.joints.length;
    const columns = Math.ceil(count / TALLEST), rows = Math.ceil(count / columns);
    this.#bones = new Bones(rig, anatomy.places);
    this.#stride = NUMBERS * joints;
    this.#values = new Float32Array(this.#stride * columns * rows);
    this.#texture = new DataTexture(this.#values, TEXELS * joints * columns, rows, RGBAFormat, FloatType);
    this.object = new InstancedMesh(surfaceOf(anatomy, count), this.#skinned(new MeshStandardMaterial({ roughness: 0.72 })), count);
    this.object.customDepthMaterial = this.#skinned(new MeshDepthMaterial());
    this.object.castShadow = true;
    this.object.frustumCulled = false;
    this.object.matrixAutoUpdate = this.object.matrixWorldAutoUpdate = false;
    const none = new Matrix4();
    for (let index = 0; index < count; index++) this.object.setMatrixAt(index, none);
    this.object.count = 0;
  }

  /**
   * Colours the characters.
   *
   * @param {Member[]} members
   */
  colour(members) {
    members.forEach(({ colour }, index) => this.object.setColorAt(index, new Color(COLOURS[colour % COLOURS.length])));
    if (this.object.instanceColor) this.object.instanceColor.needsUpdate = true;
  }

  /**
   * Poses a character.
   *
   * @param {number} index
   * @param {Pose} pose
   * @param {number} heading
   * @param {number} x
   * @param {number} z
   */
  set(index, pose, heading, x, z) {
    this.#bones.write(pose, heading, x, z, this.#values, index * this.#stride);
  }

  /** Shows what was set. @param {number} count of the characters that are there */
  show(count) {
    this.object.count = count;
    this.#texture.needsUpdate = true;
  }

  dispose() {
    this.object.removeFromParent();
    this.object.geometry.dispose();
    this.object.material.dispose();
    this.object.customDepthMaterial?.dispose();
    this.object.dispose();
    this.#texture.dispose();
  }

  /**
   * @template {MeshStandardMaterial | MeshDepthMaterial} Material
   * @param {Material} material
   */
  #skinned(material) {
    material.defines = { ...material.defines, JOINTS: this.rig.joints.length };
    material.onBeforeCompile = (shader) => {
      shader.uniforms.joints = { value: this.#texture };
      for (const [chunk, text] of [
        ['skinning_pars_vertex', PARS], ['skinbase_vertex', BASE], ['skinnormal_vertex', 'objectNormal = mat3(jointed) * objectNormal;'],
        ['color_vertex', 'vColor.rgb = instanceColor * (1.0 - abs(shade)) + max(shade, 0.0);'],
        ['skinning_vertex', 'transformed = (jointed * vec4(transformed, 1.0)).xyz;'],
      ]) shader.vertexShader = shader.vertexShader.replace(`#include <${chunk}>`, text);
    };
    return material;
  }
}

/**
 * @param {Anatomy} anatomy
 * @param {number} count
 */
function surfaceOf(anatomy, count) {
  const shape = mannequin(anatomy, count > FINE ? new CoarseShape(count > 10 * FINE ? 3 : 2) : undefined);
  const geometry = geometryOf(shape);
  geometry.setAttribute('shade', new BufferAttribute(Float32Array.from(shape.shades), 1));
  return geometry;
}
