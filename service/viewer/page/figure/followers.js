import { SkinnedMesh } from '../vendor/three.js';

/** @import { Object3D } from '../vendor/three.js' */
/** @import { Nodes } from '../vendor/motionsplice.js' */

/**
 * Lets what hangs on bones above the body follow the body. Many rigs have a bone at the feet that stays where the character
 * began; vertices with a small weight of it would be drawn out into spikes.
 *
 * @param {Object3D} model with the number of each node of the rig as `userData.rigNode`
 * @param {Nodes} nodes that the service moves
 */
export function followBody(model, { moved, turned, still }) {
  const driven = new Set([...moved, ...turned, ...still.map(({ node }) => node)]);
  const isDriven = (/** @type {Object3D} */ object) => driven.has(object.userData.rigNode);
  /** @type {Map<Object3D, number>} driven nodes below each node */
  const below = new Map();
  model.traverse((object) => {
    if (isDriven(object)) object.traverseAncestors((above) => below.set(above, (below.get(above) ?? 0) + 1));
  });
  let body = /** @type {Object3D | undefined} */ (undefined);
  for (const [object, count] of below) if (isDriven(object) && count > (body ? below.get(body) ?? 0 : 0)) body = object;
  model.traverse((mesh) => {
    if (!(mesh instanceof SkinnedMesh)) return;
    const { bones, boneInverses } = mesh.skeleton;
    const at = bones.findIndex((bone) => bone === body);
    if (at < 0) return;
    bones.forEach((bone, place) => {
      if (isDriven(bone) || !below.has(bone)) return;
      bones[place] = bones[at];
      boneInverses[place] = boneInverses[at];
    });
  });
}
