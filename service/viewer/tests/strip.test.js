import assert from 'node:assert/strict';
import { test } from 'node:test';
import { CharacterError, openGlb, writeGlb } from '../page/figure/glb.js';
import { checkReadable } from '../page/figure/readable.js';
import { strip } from '../page/figure/strip.js';
import { character, edited } from './glb_files.js';

test('a GLB file is read as it was written', () => {
  const { document, binary } = character();
  const found = openGlb(writeGlb(document, binary));
  assert.deepEqual(found.document, document);
  assert.deepEqual(found.binary, binary);
});

test('a rig has its nodes, its skins once, and its bones, and nothing else', () => {
  const { document, binary } = character();
  const { rig, nodes } = strip(document, binary);
  const found = openGlb(rig);
  assert.deepEqual(nodes, [1, 2, 3, 4, 5]);
  assert.deepEqual(found.document.nodes, [
    { name: 'Armature', scale: [0.01, 0.01, 0.01], children: [2] },
    { name: 'Leg', translation: [0, -1, 0], children: [3] },
    { name: 'Hips', rotation: [0, 0, 0, 1], children: [1] },
    { name: 'Leg_end', translation: [0, -1, 0] },
    { name: 'Root', children: [0] },
  ]);
  assert.deepEqual(found.document.skins, [{ joints: [2, 1], inverseBindMatrices: 0 }]);
  assert.deepEqual(found.document.extensions, {
    VRM: { humanoid: { humanBones: [{ bone: 'hips', node: 2 }] } },
    VRMC_vrm: { specVersion: '1.0', humanoid: { humanBones: { hips: { node: 2 }, leftUpperLeg: { node: 1 } } } },
  });
  assert.deepEqual(Object.keys(found.document).sort(), ['accessors', 'asset', 'bufferViews', 'buffers', 'extensions', 'nodes', 'skins']);
  assert.deepEqual(found.binary, binary.subarray(64, 192));
  assert.doesNotMatch(new TextDecoder().decode(rig), /secret|extras|Body|Camera/);
});

test('a rig of thousands of meshes is small', () => {
  const { document, binary } = character();
  for (let mesh = 0; mesh < 5000; mesh++) document.nodes.push({ name: `mesh ${mesh}`, mesh: 0 });
  assert.ok(strip(document, binary).rig.length < 1500);
});

for (const [name, edit, problem] of /** @type {[string, (document: any) => void, RegExp][]} */ ([
  ['no skin', (file) => { file.skins = []; }, /no skin/],
  ['a child that is no node', (file) => file.nodes[1].children.push(99), /damaged/],
  ['a cycle', (file) => { file.nodes[2].children = [3]; file.nodes[1].children = []; }, /damaged/],
  ['a joint that is no node', (file) => { file.skins[0].joints = [77]; }, /damaged/],
  ['matrices beyond its end', (file) => { file.accessors[0].count = 1e9; }, /damaged/],
  ['matrices without data', (file) => { delete file.accessors[0].bufferView; }, /damaged/],
  ['no accessors', (file) => { delete file.accessors; }, /damaged/],
  ['nodes that are a number', (file) => { file.nodes = 3; }, /damaged/],
  ['two bodies', (file) => {
    for (const body of [0, 1]) {
      const first = file.nodes.length;
      for (let bone = 0; bone < 20; bone++) file.nodes.push({ name: `${body} ${bone}`, ...(bone < 19 && { children: [first + bone + 1] }) });
      file.skins.push({ joints: Array.from({ length: 20 }, (_, bone) => first + bone) });
    }
  }, /has 2 skeletons/],
])) {
  test(`${name}: a sentence says it`, () => {
    const { document, binary } = openGlb(edited(edit));
    assert.throws(() => strip(document, binary), (error) => error instanceof CharacterError && problem.test(error.message));
  });
}

test('files that are not GLB, or cut short, are refused', () => {
  const good = edited(() => {});
  for (const [bytes, problem] of /** @type {[Uint8Array, RegExp][]} */ ([
    [new Uint8Array(0), /not a GLB/], [new TextEncoder().encode('HIERARCHY ROOT Hips {{{{{{{{'), /not a GLB/],
    [good.subarray(0, 200), /cut short/], [writeGlb(/** @type {any} */ (3), new Uint8Array(4)), /JSON cannot be read/],
  ])) assert.throws(() => openGlb(bytes), (error) => error instanceof CharacterError && problem.test(error.message));
});

test('what the page cannot read is said before it is tried', () => {
  for (const [more, problem] of /** @type {[object, RegExp][]} */ ([
    [{ extensionsRequired: ['KHR_draco_mesh_compression'] }, /Draco/], [{ extensionsUsed: ['KHR_draco_mesh_compression'] }, /Draco/],
    [{ extensionsRequired: ['EXT_meshopt_compression'] }, /meshopt/], [{ extensionsRequired: ['KHR_texture_basisu'] }, /KTX2/],
    [{ buffers: [{ uri: 'body.bin', byteLength: 3 }] }, /other files/],
  ])) assert.throws(() => checkReadable({ ...character().document, ...more }), problem);
  checkReadable(character().document);
});
