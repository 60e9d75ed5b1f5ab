/** @import { Frames } from './frames.js' */
/** @import { Axes } from './rig.js' */
/** @import { Held } from './playback.js' */

/**
 * Where a command has put a character.
 *
 * @typedef {object} Placed
 * @property {number} number of the first frame there
 * @property {ArrayLike<number>} ground position and heading, [4]
 */

/** @type {Record<Axes, [number, number]>} */
const ACROSS = { gltf: [2, 0], unity: [2, 0], godot: [2, 0], unreal: [0, 1], blender: [0, 1] }; // a turn goes from one to the other

/**
 * Adds root motion up. A character that is created again after a lost connection goes on where it was.
 *
 * @param {Frames} frames
 * @param {number} index of the frame in the message
 * @param {Held | undefined} before the frame before
 * @param {(id: number) => Placed | undefined} placed where a character was put last
 * @returns {Float64Array} position and heading of each character, [n][4]
 */
export function stepped(frames, index, before, placed) {
  const { ids, rootSteps, rootTurns, characters, frame } = frames;
  const grounds = new Float64Array(4 * characters);
  const [from, to] = ACROSS[frames.rig.axes];
  for (let row = 0; row < characters && ids && rootSteps && rootTurns; row++) {
    const start = placed(ids[row]);
    const rowBefore = before?.frames.rowOf(ids[row], row);
    const isNew = start !== undefined && start.number <= frame + index && (!before || start.number > before.number);
    if (isNew || rowBefore === undefined || !before) {
      if (start) grounds.set(start.ground, 4 * row);
      continue;
    }
    const step = rootSteps.subarray(3 * (index * characters + row));
    const ground = grounds.subarray(4 * row, 4 * row + 4);
    ground.set(before.grounds.subarray(4 * rowBefore, 4 * rowBefore + 4));
    const sin = Math.sin(ground[3]), cos = Math.cos(ground[3]);
    for (let axis = 0; axis < 3; axis++) {
      ground[axis] += axis === from ? cos * step[from] - sin * step[to] : axis === to ? sin * step[from] + cos * step[to] : step[axis];
    }
    ground[3] += rootTurns[index * characters + row];
  }
  return grounds;
}
