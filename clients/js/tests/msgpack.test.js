import assert from 'node:assert/strict';
import test from 'node:test';
import { decode, FormatError } from '../motionsplice.js';

const hex = (text) => Uint8Array.from(text.match(/[0-9a-f]{2}/g) ?? [], (byte) => parseInt(byte, 16));

for (const [bytes, value] of [
  ['00', 0], ['7f', 127], ['e0', -32], ['ff', -1], ['c0', null], ['c2', false], ['c3', true],
  ['cc ff', 255], ['cd 01 00', 256], ['ce ff ff ff ff', 2 ** 32 - 1], ['cf 00 00 00 01 00 00 00 00', 2 ** 32],
  ['d0 80', -128], ['d1 80 00', -32768], ['d2 80 00 00 00', -(2 ** 31)], ['d3 ff ff ff ff 00 00 00 00', -(2 ** 32)],
  ['ca 3f c0 00 00', 1.5], ['cb 3f f8 00 00 00 00 00 00', 1.5],
  ['a2 c3 a9', 'é'], ['d9 01 61', 'a'], ['da 00 01 61', 'a'], ['db 00 00 00 01 61', 'a'],
  ['c4 01 07', Uint8Array.of(7)], ['c5 00 01 07', Uint8Array.of(7)], ['c6 00 00 00 01 07', Uint8Array.of(7)],
  ['92 01 90', [1, []]], ['dc 00 01 01', [1]], ['dd 00 00 00 01 01', [1]],
  ['81 a1 61 01', { a: 1 }], ['de 00 01 a1 61 01', { a: 1 }], ['df 00 00 00 01 a1 61 01', { a: 1 }],
]) {
  test(`${bytes} is ${JSON.stringify(value)}`, () => assert.deepEqual(decode(hex(bytes)), value));
}

for (const [bytes, words] of [
  ['', /^byte 0: 1 bytes expected, but the message has 0 more/], ['01 02', /^1 bytes follow the message/],
  ['c1', /^byte 0: 0xc1 begins no value/], ['d4 00 00', /0xd4/], ['a2 61', /^byte 1: 2 bytes expected/],
  ['a2 ff fe', /^byte 1: the text is not UTF-8/], ['81 01 02', /^byte 1: a map's key is not text/],
  ['dd ff ff ff ff', /^byte 5: the message ends within a list/], ['df ff ff ff ff', /ends within/],
  ['91 91 91 91 91 91 91 91 91 00', /^byte 9: more than 8 lists/],
]) {
  test(`${bytes} is refused`, () => assert.throws(() => decode(hex(bytes)), (error) => error instanceof FormatError && words.test(error.message)));
}

test('a key __proto__ is a key', () => {
  const found = decode(hex('81 a9 5f 5f 70 72 6f 74 6f 5f 5f 80'));
  assert.deepEqual(Object.keys(found), ['__proto__']);
  assert.equal(Object.getPrototypeOf(found), Object.prototype);
});
