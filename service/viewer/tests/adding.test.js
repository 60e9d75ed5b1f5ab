import assert from 'node:assert/strict';
import { test } from 'node:test';
import { faultOf, NAME, nameFor, ordered, parts } from '../page/adding/files.js';

test('names are those of the files, as near as the service accepts', () => {
  const names = { 'walk.bvh': 'walk', 'My jog é (2).FBX': 'My_jog_e_2', '_hidden.glb': 'hidden', '歩く.bvh': 'clip', 'a.b.c.bvh': 'a_b_c', 'walk+wave.bvh': 'walk+wave' };
  for (const [file, name] of Object.entries(names)) assert.equal(nameFor(file), name);
  for (const file of ['', '.bvh', '---.bvh', `${'x'.repeat(300)}.bvh`, '../../etc/passwd', '<b>.bvh']) assert.match(nameFor(file), NAME);
});

test('a suffix is in lower case', () => {
  assert.deepEqual(parts('Walk.BVH'), { stem: 'Walk', suffix: '.bvh' });
  assert.deepEqual(parts('README'), { stem: 'README', suffix: '' });
});

test('files that cannot be clips are refused with a reason', () => {
  assert.equal(faultOf({ name: 'walk.bvh', size: 10 }, 100), '');
  assert.match(faultOf({ name: 'walk.png', size: 10 }, 100), /^Not a motion file\. Choose \.bvh, .* or \.asf\.$/);
  assert.match(faultOf({ name: 'walk.bvh', size: 0 }, 100), /empty/);
  assert.match(faultOf({ name: 'walk.bvh', size: 3e8 }, 268435456), /has 300 MB, .* at most 268 MB/);
});

test('skeletons are sent before the motions that need them', () => {
  const names = ordered(['02_10.amc', '02_9.amc', 'a.bvh', '02.asf'].map((name) => ({ name }))).map(({ name }) => name);
  assert.deepEqual(names, ['02.asf', '02_9.amc', '02_10.amc', 'a.bvh']);
});
