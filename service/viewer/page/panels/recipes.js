/** The code that gives a take outside the page: a shell command and a Python script. Pure functions, so tests can run the code. */

/** @import { Command, Take } from '../takes.js' */

/**
 * Returns a name for a file of a take, as `walk+wave`.
 *
 * @param {Take} take
 */
export function fileName(take) {
  const names = take.commands.flatMap(({ locomotion, action, hands }) => [
    ...(typeof locomotion === 'string' ? [locomotion] : Object.keys(locomotion ?? {})),
    ...[action, hands].filter((name) => typeof name === 'string'),
  ]);
  const text = [...new Set(names)].join('+').replace(/[^\p{Letter}\p{Number}+\-_.]/gu, '_').replace(/^\.+/, '');
  return text.slice(0, 120) || 'take';
}

/**
 * Returns a shell command that saves a take as a file. It reads the token from the shell's variable TOKEN, so the command can be
 * shared.
 *
 * @param {string} url of the service
 * @param {Take} take
 * @param {string} format
 * @param {boolean} hasToken
 */
export function curlLine(url, take, format, hasToken) {
  const parts = ['curl', '--fail-with-body', '-o', quoted(`${fileName(take)}.${format}`), '-H', quoted('Content-Type: application/json')];
  if (hasToken) parts.push('-H', '"Authorization: Bearer $TOKEN"');
  parts.push('-d', quoted(JSON.stringify(take)), quoted(`${url}/v1/take?format=${format}`));
  return parts.join(' ');
}

/**
 * Returns a Python script that computes the same motion from the bank's folder and saves it as BVH.
 *
 * @param {Take} take
 * @param {string} bank its digest
 */
export function pythonLines(take, bank) {
  const [create, ...later] = take.commands;
  const first = later.filter(({ at }) => at === 0).map((command) => `${call(command)}\n`);
  const rest = later.filter(({ at }) => at > 0).map((command) => `    if frame == ${command.at}:\n        ${call(command)}\n`);
  const name = fileName(take);
  return `from pathlib import Path

import numpy as np
from motionsplice import Action, Aim, Bank, Characters, Clip, Evaluator, Look, Stage, dump_bvh

bank = Bank.open("bank")  # the folder of the bank ${bank}
evaluator = Evaluator(bank)
characters = Characters(Stage(evaluator), rate=${take.rate})
[hero] = characters.add(1, ${python(create.locomotion)}, loop=${python(create.loop ?? true)})
${first.join('')}poses = evaluator.poses(1)
roots, rotations = [], []
for frame in range(${take.frames}):
    if frame:
        characters.advance()
${rest.join('')}    characters.evaluate(poses)
    roots.append(poses.root_positions[0].astype(np.float64))
    rotations.append(poses.rotations[0].astype(np.float64))

clip = Clip(${python(name)}, bank.skeleton, ${take.rate}, np.array(roots), np.array(rotations))
Path(${python(`${name}.bvh`)}).write_bytes(dump_bvh(clip))
`;
}

/** Defaults of Python's `Action`; the script omits them. @type {Record<string, unknown>} */
const ACTION = {
  when: 'now', start: 0, weight: 1, mask: 'upper_body', method: 'splice', posture: 'relative', loop: true,
};

/** @param {Command} command */
function call({ at, do: name, action, hands, ...settings }) {
  const named = (/** @type {object} */ values) => Object.entries(values).map(([key, value]) => `${key}=${python(value)}`);
  if (name === 'lock_feet') return `characters.lock_feet([hero], ${python(settings.lock_feet)})`;
  if (name === 'look' || name === 'aim') {
    const { point, blend, ...others } = settings;
    return `characters.${name}([hero], ${name === 'look' ? 'Look' : 'Aim'}(${[python(point), ...named(others)].join(', ')}), blend=${python(blend)})`;
  }
  if (name === 'wear') return `characters.wear(${['[hero]', python(hands), ...named(settings)].join(', ')})`;
  const others = Object.fromEntries(Object.entries(settings).filter(([key, value]) => ACTION[key] !== value));
  return `characters.act([hero], Action(${[python(action), ...named(others)].join(', ')}))`;
}

/**
 * Returns a value as a Python literal. A JSON string is a valid Python string.
 *
 * @param {unknown} value
 * @returns {string}
 */
function python(value) {
  if (typeof value === 'boolean') return value ? 'True' : 'False';
  if (value === null || value === undefined) return 'None';
  if (typeof value !== 'object') return JSON.stringify(value);
  if (Array.isArray(value)) return `(${value.map(python).join(', ')})`;
  return `{${Object.entries(value).map(([key, one]) => `${JSON.stringify(key)}: ${python(one)}`).join(', ')}}`;
}

/**
 * Quotes a text for a POSIX shell.
 *
 * @param {string} text
 */
function quoted(text) {
  return `'${text.replaceAll("'", `'\\''`)}'`;
}
