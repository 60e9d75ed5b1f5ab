import { messageOf } from '../errors.js';
import { Mesh } from '../vendor/three.js';
import { animated } from './animated.js';
import { Figure, materialsOf } from './figure.js';
import { CharacterError, openGlb, writeGlb } from './glb.js';
import { checkReadable, withOwnPictures } from './readable.js';
import { Ring } from './ring.js';
import { strip } from './strip.js';

/** @import { MeshStandardMaterial, Object3D } from '../vendor/three.js' */
/** @import { Nodes } from '../vendor/motionsplice.js' */
/** @import { Document } from './glb.js' */

const METAL = 0.4; // the stage has no surroundings that a metal could mirror: it would be black

let loaded = 0;

/** A character of the user's, from a GLB or VRM file, which stays on the user's machine. */
export class Character {
  /** Of this character among all that were loaded. */
  id = ++loaded;
  /** Metres by which it is raised, so that its soles are on the ground where those of the mannequin are. */
  lift = 0;
  /** What it and its path are made smaller by, so that a body that is large for its legs is not a giant. */
  shrink = 1;
  #figures = 0;
  #isOver = false;

  /**
   * @param {string} name
   * @param {string} rig its nodes and skins as a GLB file, in base64: all of it that the service gets
   * @param {Object3D} model with the number of each node of `rig` as `userData.rigNode`
   * @param {(source: Object3D) => Object3D} clone
   * @param {{ document: Document, binary: Uint8Array, nodes: number[] }} file, and the number there of each node of the rig
   */
  constructor(name, rig, model, clone, file) {
    this.name = name;
    this.rig = rig;
    this.model = model;
    this.clone = () => clone(model);
    this.file = file;
  }

  /**
   * @param {string} name
   * @param {ArrayBuffer} data
   * @throws {CharacterError}
   */
  static async read(name, data) {
    const bytes = new Uint8Array(data);
    const { document, binary } = openGlb(bytes);
    checkReadable(document);
    const { rig, nodes } = strip(document, binary);
    const { GLTFLoader, clone } = await import('../vendor/loader.js');
    /** @type {string[]} */
    const pictures = [];
    const own = withOwnPictures(document, pictures);
    try {
      const { scene, parser } = await new GLTFLoader().parseAsync(own === document ? data : writeGlb(own, binary).buffer, '');
      const places = new Map(nodes.map((node, place) => [node, place]));
      for (const [object, { nodes: node }] of /** @type {Map<any, { nodes?: number }>} */ (parser.associations)) {
        if (object.isObject3D && node !== undefined) object.userData = { rigNode: places.get(node) };
      }
      prepare(scene);
      return new Character(name, base64(rig), scene, clone, { document, binary, nodes });
    } catch (error) {
      throw new CharacterError(`The file cannot be read: ${messageOf(error)}`);
    } finally {
      for (const url of pictures) URL.revokeObjectURL(url);
    }
  }

  /**
   * Returns what lies below a figure.
   *
   * @param {string} colour
   */
  ring(colour) {
    return new Ring(colour);
  }

  /**
   * Returns a figure of it.
   *
   * @param {Nodes} nodes its motion
   */
  figure(nodes) {
    this.#figures += 1;
    return new Figure(this, nodes);
  }

  /**
   * Returns a copy of its file with one more animation.
   *
   * @param {Nodes} nodes
   * @param {string} name
   */
  animated(nodes, name) {
    const { document, binary, nodes: places } = this.file;
    return animated(document, binary, places, nodes, name);
  }

  /** Counts a figure that was disposed of. */
  leave() {
    this.#figures -= 1;
    if (this.#isOver && !this.#figures) this.#free();
  }

  /** Frees what the graphics card holds, once no figure shows it any more. */
  dispose() {
    this.#isOver = true;
    if (!this.#figures) this.#free();
  }

  #free() {
    this.model.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      object.geometry.dispose();
      for (const material of materialsOf(object)) {
        for (const value of Object.values(material)) if (value?.isTexture) free(value);
        material.dispose();
      }
    });
  }
}

/** @param {{ dispose(): void, image?: Partial<ImageBitmap> }} texture */
function free(texture) {
  texture.dispose();
  texture.image?.close?.();
}

/**
 * Makes a model fit for the stage: it casts shadows, brings no light, and is drawn wherever its bones are.
 *
 * @param {Object3D} model
 */
function prepare(model) {
  let hasMesh = false;
  model.traverse((object) => {
    if (object instanceof Mesh) {
      hasMesh = object.castShadow = true;
      object.frustumCulled = false;
      for (const material of /** @type {Partial<MeshStandardMaterial>[]} */ (materialsOf(object))) {
        if (material.metalness) material.metalness = Math.min(material.metalness, METAL);
      }
    }
    if ('intensity' in object) object.intensity = 0;
  });
  if (!hasMesh) throw new CharacterError('it has no mesh in its scene.');
}

/** @param {Uint8Array} bytes */
function base64(bytes) {
  let text = '';
  for (let at = 0; at < bytes.length; at += 0x8000) text += String.fromCharCode(...bytes.subarray(at, at + 0x8000));
  return btoa(text);
}
