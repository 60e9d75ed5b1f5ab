import { Group, Mesh, Quaternion, Vector3 } from '../vendor/three.js';

/** @import { Material, Object3D, SkinnedMesh } from '../vendor/three.js' */
/** @import { Nodes } from '../vendor/motionsplice.js' */
/** @import { Character } from './character.js' */

const UP = new Vector3(0, 1, 0);

/** A user's character that moves as one side does. */
export class Figure {
  object = new Group();
  #scaled = new Group();
  /** @type {{ object: Object3D, place: number }[]} */
  #moved = [];
  /** @type {{ object: Object3D, place: number }[]} */
  #turned = [];
  #next = new Quaternion();
  #ahead = new Vector3();
  #opacity = 1;
  /** Materials of its own, once it is seen through. @type {Material[] | undefined} */
  #own;

  /**
   * @param {Character} character
   * @param {Nodes} nodes
   */
  constructor(character, nodes) {
    this.character = character;
    this.nodes = nodes;
    const model = character.clone();
    this.#scaled.scale.setScalar(nodes.scale);
    this.#scaled.position.y = character.lift;
    this.#scaled.add(model);
    this.object.add(this.#scaled);
    /** @type {Map<number, Object3D>} */
    const objects = new Map();
    model.traverse((object) => {
      if (object.userData.rigNode !== undefined) objects.set(object.userData.rigNode, object);
    });
    const present = (/** @type {number[]} */ listed) => listed.flatMap((node, place) => {
      const object = objects.get(node);
      return object ? [{ object, place }] : [];
    });
    this.#moved = present(nodes.moved);
    this.#turned = present(nodes.turned);
    for (const { node, translation, rotation } of nodes.still) {
      if (translation) objects.get(node)?.position.fromArray(translation);
      if (rotation) objects.get(node)?.quaternion.fromArray(rotation);
    }
  }

  /**
   * Shows a moment of the motion.
   *
   * @param {number} seconds
   */
  at(seconds) {
    const { count, rate, moved, turned, translations, rotations } = this.nodes;
    const place = Math.max(0, Math.min(count - 1, seconds * rate));
    const before = Math.floor(place), after = Math.min(before + 1, count - 1), share = place - before;
    for (const { object, place: column } of this.#moved) {
      object.position.fromArray(translations, 3 * (before * moved.length + column));
      if (share) object.position.lerp(this.#ahead.fromArray(translations, 3 * (after * moved.length + column)), share);
    }
    for (const { object, place: column } of this.#turned) {
      object.quaternion.fromArray(rotations, 4 * (before * turned.length + column));
      if (share) object.quaternion.slerp(this.#next.fromArray(rotations, 4 * (after * turned.length + column)), share);
    }
  }

  /**
   * Turns it about the vertical, and moves it.
   *
   * @param {ArrayLike<number>} offset metres, [3]
   * @param {number} [turn] radians
   */
  place(offset, turn = 0) {
    this.object.position.set(offset[0], offset[1], offset[2]);
    this.object.quaternion.setFromAxisAngle(UP, turn);
  }

  /** @param {number} opacity */
  set opacity(opacity) {
    if (opacity === this.#opacity) return;
    this.#opacity = opacity;
    if (!this.#own) {
      this.#own = [];
      this.#meshes((mesh) => {
        const own = materialsOf(mesh).map((material) => material.clone());
        mesh.material = Array.isArray(mesh.material) ? own : own[0];
        for (const material of own) {
          material.userData.before = { transparent: material.transparent, opacity: material.opacity };
          this.#own?.push(material);
        }
      });
    }
    for (const material of this.#own) {
      const { before } = material.userData;
      material.transparent = opacity < 1 || before.transparent;
      material.opacity = opacity * before.opacity;
      material.needsUpdate = true;
    }
  }

  /** Frees what it has of its own; the character stays. */
  dispose() {
    this.object.removeFromParent();
    for (const material of this.#own ?? []) material.dispose();
    this.#meshes((mesh) => /** @type {Partial<SkinnedMesh>} */ (mesh).skeleton?.dispose());
    this.character.leave();
  }

  /** @param {(mesh: Mesh) => void} visit */
  #meshes(visit) {
    this.object.traverse((object) => {
      if (object instanceof Mesh) visit(object);
    });
  }
}

/**
 * @param {Mesh} mesh
 * @returns {Material[]}
 */
export function materialsOf({ material }) {
  return Array.isArray(material) ? material : [material];
}
