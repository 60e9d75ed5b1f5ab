import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import test from 'node:test';
import { curlLine, fileName, pythonLines } from '../page/panels/recipes.js';

const take = {
  rate: 60,
  frames: 361,
  commands: [
    { at: 0, do: 'create', locomotion: { walk: 0.5, run: 0.5 }, loop: true },
    { at: 30, do: 'act', action: 'wave', when: 'foot', start: 0, blend: 0.2, blend_out: 0.2, weight: 1, method: 'naive', loop: false },
    { at: 0, do: 'wear', hands: 'count', blend: 0 },
  ],
};
const hostile = { rate: 30, frames: 2, commands: [{ at: 0, do: 'create', locomotion: `it's "$(id)" \\ é/../<b>`, loop: false }] };

test('a file is named after the clips', () => {
  assert.equal(fileName(take), 'walk+run+wave+count');
});

test('the name of a file has no separators and does not begin with a dot', () => {
  assert.equal(fileName(hostile), 'it_s____id_____é_..__b_');
  assert.equal(fileName({ ...take, commands: [{ at: 0, do: 'create', locomotion: '../..' }] }), '_..');
});

test('the shell passes the take on as it is', () => {
  const line = curlLine('http://127.0.0.1:8000', hostile, 'glb', true);
  const printed = execFileSync('sh', ['-c', `TOKEN=secret; curl() { for one in "$@"; do printf '%s\\n' "$one"; done; }; ${line}`], { encoding: 'utf8' });
  const words = printed.split('\n');
  assert.deepEqual(JSON.parse(words[words.indexOf('-d') + 1]), hostile);
  assert.ok(words.includes('Authorization: Bearer secret'));
  assert.equal(words.at(-2), 'http://127.0.0.1:8000/v1/take?format=glb');
});

test('a line without a token sends none', () => {
  assert.ok(!curlLine('http://127.0.0.1:8000', take, 'bvh', false).includes('Authorization'));
});

test('the lines of Python lock feet, look and aim', () => {
  const [create] = take.commands, target = { at: 0, point: [1, 1.5, -3], blend: 0 };
  const commands = [create, { at: 0, do: 'lock_feet', lock_feet: true }, { ...target, do: 'look', weight: 0.5 }, { ...target, do: 'aim', part: 'left_arm' }];
  const lines = pythonLines({ ...take, commands }, '1234').split('\n');
  const at = lines.indexOf('characters.lock_feet([hero], True)');
  assert.equal(lines[at + 1], 'characters.look([hero], Look((1, 1.5, -3), weight=0.5), blend=0)');
  assert.equal(lines[at + 2], 'characters.aim([hero], Aim((1, 1.5, -3), part="left_arm"), blend=0)');
});

test('the lines of Python give commands at their frames, without defaults', () => {
  const lines = pythonLines(take, '1234').split('\n');
  assert.ok(lines.includes('[hero] = characters.add(1, {"walk": 0.5, "run": 0.5}, loop=True)'));
  assert.ok(lines.includes('characters.wear([hero], "count", blend=0)'));
  const at = lines.indexOf('    if frame == 30:');
  assert.equal(lines[at + 1],
    '        characters.act([hero], Action("wave", when="foot", blend=0.2, blend_out=0.2, method="naive", loop=False))');
});
