// GLB files for tests: a small skinned mesh, and what can be wrong with it.
import { writeGlb } from '../page/figure/glb.js';

/** Returns the document and the binary chunk of a character: hips with two legs, a tip, a mesh, a picture and an animation. */
export function character() {
  const binary = new Uint8Array(1000);
  const floats = new Float32Array(binary.buffer, 0, 64);
  for (let joint = 0; joint < 3; joint++) for (let axis = 0; axis < 4; axis++) floats[16 * joint + 5 * axis] = 1 + joint;
  const document = {
    asset: { version: '2.0', generator: 'x' },
    scene: 0,
    scenes: [{ nodes: [0, 5] }],
    nodes: [
      { name: 'Camera', camera: 0 },
      { name: 'Armature', children: [3, 6], scale: [0.01, 0.01, 0.01], extras: { secret: 1 } },
      { name: 'Leg', translation: [0, -1, 0], children: [4, 7] },
      { name: 'Hips', children: [2], rotation: [0, 0, 0, 1] },
      { name: 'Leg_end', translation: [0, -1, 0] },
      { name: 'Root', children: [1] },
      { name: 'Body', mesh: 0, skin: 0 },
      { name: 'Shoe', mesh: 0 },
    ],
    skins: [{ joints: [3, 2], inverseBindMatrices: 0, skeleton: 3 }, { joints: [3, 2], inverseBindMatrices: 0 }],
    meshes: [{ primitives: [{ attributes: {} }] }],
    materials: [{}],
    images: [{ bufferView: 1 }],
    animations: [{ name: 'secret', channels: [], samplers: [] }],
    buffers: [{ byteLength: 1000 }],
    bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: 192 }, { buffer: 0, byteOffset: 192, byteLength: 500 }],
    accessors: [{ bufferView: 0, byteOffset: 64, componentType: 5126, type: 'MAT4', count: 2 }],
    extensions: {
      VRM: { humanoid: { humanBones: [{ bone: 'hips', node: 3, useDefaultValues: true }] }, meta: { title: 'secret' } },
      VRMC_vrm: { specVersion: '1.0', meta: {}, humanoid: { humanBones: { hips: { node: 3 }, leftUpperLeg: { node: 2 } } } },
    },
  };
  return { document, binary };
}

/** @param {(document: any) => void} edit */
export function edited(edit) {
  const { document, binary } = character();
  edit(document);
  return writeGlb(document, binary);
}
