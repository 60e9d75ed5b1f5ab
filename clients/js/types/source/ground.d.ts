/**
 * Adds root motion up. A character that is created again after a lost connection goes on where it was.
 *
 * @param {Frames} frames
 * @param {number} index of the frame in the message
 * @param {Held | undefined} before the frame before
 * @param {(id: number) => Placed | undefined} placed where a character was put last
 * @returns {Float64Array} position and heading of each character, [n][4]
 */
export function stepped(frames: Frames, index: number, before: Held | undefined, placed: (id: number) => Placed | undefined): Float64Array;
/**
 * Where a command has put a character.
 */
export type Placed = {
    /**
     * of the first frame there
     */
    number: number;
    /**
     * position and heading, [4]
     */
    ground: ArrayLike<number>;
};
import type { Frames } from './frames.js';
import type { Held } from './playback.js';
