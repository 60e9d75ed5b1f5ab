/** @import { Frames } from './frames.js' */
/** @import { Rig } from './rig.js' */
/** The frames of a splice, which can be shown at any time. */
export class Motion {
    /**
     * @param {Rig} rig
     * @param {number} rate frames per second
     */
    constructor(rig: Rig, rate: number);
    /** @type {[Frames, number][]} */
    held: [Frames, number][];
    /** @type {[Pose, Pose] | undefined} */
    poses: [Pose, Pose] | undefined;
    rig: Rig;
    rate: number;
    /** Seconds from the first frame that is there to the last. */
    get duration(): number;
    /**
     * Adds a message of frames, which follows those that are there.
     *
     * @param {Frames} frames
     */
    add(frames: Frames): this;
    /**
     * Returns the pose at a time, between two frames; undefined if there are none. The next call changes it.
     *
     * @param {number} seconds since the first frame; the first and the last pose are held
     */
    pose(seconds: number): Pose | undefined;
}
import type { Frames } from './frames.js';
import { Pose } from './pose.js';
import type { Rig } from './rig.js';
