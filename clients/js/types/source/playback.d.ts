/** Holds frames and decides which to show: the protocol's "Between frames". All times are in seconds. */
export class Playback {
    /** @type {Held[]} */
    held: Held[];
    /** @type {{ at: number, value: number }[]} */
    samples: {
        at: number;
        value: number;
    }[];
    offset: number;
    lateness: number;
    /** @type {number | undefined} */
    delay: number | undefined;
    before: number;
    /**
     * Takes a message.
     *
     * @param {Frames} frames
     * @param {number} now by the client's clock
     * @param {(id: number) => Placed | undefined} placed where a character was put last
     */
    take(frames: Frames, now: number, placed: (id: number) => Placed | undefined): void;
    /**
     * Forgets the frames from a number on, which a command has changed.
     *
     * @param {number} number
     */
    discard(number: number): void;
    /**
     * @param {number} now
     * @param {number} value
     */
    measure(now: number, value: number): void;
    /**
     * Returns the frames between which to show characters, and how far from the first to the second; undefined before
     * the first message. Frames that are over are dropped.
     *
     * @param {number} now by the client's clock
     */
    at(now: number): {
        a: Held;
        b: Held | undefined;
        share: number;
    } | undefined;
}
/**
 * One frame that is held: the `index`-th of a message, from 0.
 */
export type Held = {
    frames: Frames;
    index: number;
    number: number;
    /**
     * seconds by the service's clock
     */
    due: number;
    /**
     * place and heading of each character, [n][4]
     */
    grounds: Float64Array;
};
import type { Frames } from './frames.js';
import type { Placed } from './ground.js';
