import assert from 'node:assert/strict';
import test from 'node:test';
import * as THREE from 'three';
import { Pose, Rig, RigError } from '../motionsplice.js';

const RIG = new Rig({
  bank: 'a', joints: ['mixamorig:Hips', 'Spine 1', 'Head', 'Leg'], parents: [-1, 0, 1, 0],
  offsets: [[0, 0, 0], [0, 0.3, 0], [0, 0.3, 0], [0, -0.5, 0]], roles: {},
}, 'gltf');

/** Bones whose own axes are turned at random, under a turned armature, in `unit`s of a metre. */
function model({ unit = 1, names = ['mixamorigHips', 'Spine_1', 'Head', 'Leg'], extra = false, loose = false } = {}) {
  const scene = new THREE.Group();
  const armature = new THREE.Group();
  armature.quaternion.random();
  armature.scale.setScalar(0.25);
  scene.add(armature);
  const bones = names.map((name) => Object.assign(new THREE.Bone(), { name }));
  const places = [[0, 1, 0], [0, 1.3, 0], [0, 1.6, 0], [0, 0.5, 0]];
  bones.forEach((bone, joint) => {
    let parent = joint && !(loose && joint === 3) ? bones[RIG.parents[joint]] : armature;
    if (extra && joint === 2) {
      const between = Object.assign(new THREE.Bone(), { name: 'twist' });
      between.quaternion.random();
      parent.add(between);
      parent = between;
    }
    parent.add(bone);
    parent.updateWorldMatrix(true);
    const turn = new THREE.Quaternion().random();
    const world = new THREE.Matrix4().compose(new THREE.Vector3(...places[joint]).multiplyScalar(unit), turn, new THREE.Vector3(1, 1, 1));
    parent.matrixWorld.clone().invert().multiply(world).decompose(bone.position, bone.quaternion, bone.scale);
    bone.scale.setScalar(1);
  });
  scene.updateMatrixWorld(true);
  return { scene, bones, skeleton: new THREE.Skeleton(bones) };
}

function pose() {
  const one = new Pose(RIG, true, false);
  one.root.set([3, 1, 2]);
  for (let joint = 0; joint < 4; joint++) one.rotations.set(new THREE.Quaternion().random().toArray(), 4 * joint);
  return one;
}

for (const unit of [1, 100, 0.01]) {
  for (const [extra, loose] of [[false, false], [true, false], [false, true]]) {
    test(`bones in units of 1/${unit} m; others between: ${extra}; a leg that hangs on none: ${loose}`, () => {
      for (let count = 0; count < 30; count++) {
        const { scene, bones, skeleton } = model({ unit, extra, loose });
        const wanted = pose();
        const target = [scene, skeleton][count % 2];
        pose().apply(target); // which must not be taken for the bind pose
        wanted.apply(target);
        scene.updateMatrixWorld(true);
        const places = wanted.worldPositions();
        bones.forEach((bone, joint) => {
          const place = new THREE.Vector3().setFromMatrixPosition(bone.matrixWorld).divideScalar(unit);
          assert.ok(place.distanceTo(new THREE.Vector3().fromArray(places, 3 * joint)) < 1e-5, `${joint}`);
        });
      }
    });
  }
}

test('a bone of the skin above the root goes with it over the ground', () => {
  for (const unit of [1, 100]) {
    for (const loose of [false, true]) {
      const { scene, bones } = model({ unit, loose });
      const base = Object.assign(new THREE.Bone(), { name: 'base' });
      const armature = scene.children[0];
      base.quaternion.random();
      base.position.random().multiplyScalar(unit);
      armature.add(base);
      scene.updateMatrixWorld(true);
      for (const child of [...armature.children]) if (child !== base) base.attach(child);
      scene.updateMatrixWorld(true);
      const skeleton = new THREE.Skeleton([...bones, base]);
      scene.add(Object.assign(new THREE.Object3D(), { skeleton }));
      const at = (bone) => new THREE.Vector3().setFromMatrixPosition(bone.matrixWorld).divideScalar(unit);
      const [ground, root] = [at(base), at(bones[0])];
      const wanted = pose();
      wanted.apply(scene);
      scene.updateMatrixWorld(true);
      const [x, , z] = wanted.root;
      assert.ok(at(base).distanceTo(new THREE.Vector3(ground.x + x - root.x, ground.y, ground.z + z - root.z)) < 1e-5);
      const places = wanted.worldPositions();
      bones.forEach((bone, joint) => assert.ok(at(bone).distanceTo(new THREE.Vector3().fromArray(places, 3 * joint)) < 1e-5));
    }
  }
});

test('bones that do not fit are refused by name', () => {
  const wanted = pose();
  const refused = (target, words) => assert.throws(() => wanted.apply(target), (error) => error instanceof RigError && words.test(error.message));
  refused(model({ names: ['a', 'b', 'c', 'd'] }).scene, /no bones are named mixamorig:Hips\. Build/);
  refused(model({ names: ['mixamorigHips', 'Spine', 'Head', 'Leg'] }).scene, /named Spine 1\./);
  const { scene, bones } = model();
  bones[1].add(bones[3]);
  refused(scene, /the bone Leg hangs on Spine_1, but its joint on mixamorigHips/);
  assert.doesNotThrow(() => wanted.apply(model({ names: ['mixamorigHips', 'Spine_1', 'other', 'Leg'] }).scene)); // the end of a chain
  assert.throws(() => new Pose(RIG, false, true).apply(model().scene), RigError);
  assert.throws(() => new Pose(new Rig({ ...described(), bank: 'b' }, 'unity'), true, false).apply(model().scene), /has the axes gltf, not unity/);
});

const described = () => ({ joints: RIG.joints, parents: [...RIG.parents], offsets: RIG.joints.map((_, at) => [...RIG.offsets.slice(3 * at, 3 * at + 3)]), roles: {} });

test('a rig that is none is refused', () => {
  const good = { ...described(), bank: 'a' };
  for (const bad of [{ bank: 1 }, { joints: [] }, { joints: undefined }, { parents: [-1, 0, 3, 0] }, { parents: [0, 0, 0, 0] },
    { parents: [-1, 0] }, { offsets: [[0, 0, 0]] }, { offsets: [[0, 0, 0], [0, 0, 0], [0, 0, NaN], [0, 0, 0]] }]) {
    assert.throws(() => new Rig({ ...good, ...bad }, 'gltf'), /a rig /);
  }
});
