/** @import { Frames } from './frames.js' */
/** @import { Rig } from './rig.js' */
/** @import { Target } from './bones.js' */
/** A character at one moment. */
export class Pose {
    /**
     * Returns a pose that can hold one of a message's.
     *
     * @param {Frames} frames
     */
    static for(frames: Frames): Pose;
    /**
     * @param {Rig} rig
     * @param {boolean} isLocal whether there are rotations
     * @param {boolean} isWorld whether there are positions of all joints
     */
    constructor(rig: Rig, isLocal: boolean, isWorld: boolean);
    rig: Rig;
    /** Position of the root [3]. */
    root: Float32Array<ArrayBuffer>;
    /** Rotations [J][4] in the parents' frames, x, y, z, w; undefined with the parts `world`. */
    rotations: Float32Array<ArrayBuffer> | undefined;
    /** Positions [J][3] of all joints, as sent; undefined with the parts `local`. */
    positions: Float32Array<ArrayBuffer> | undefined;
    /**
     * Whether this pose can hold one of a message's.
     *
     * @param {Frames} frames
     */
    fits(frames: Frames): boolean;
    /**
     * Copies a pose from a message.
     *
     * @param {Frames} frames
     * @param {number} number of the frame in the message, from 0
     * @param {number} row of the character
     */
    read(frames: Frames, number: number, row: number): void;
    /**
     * Moves this pose towards another of the same rig: positions along a line, rotations along the shorter arc's chord,
     * normalised. At 30 degrees from one to the other that differs from the arc by at most 0.03 degrees.
     *
     * @param {Pose} other
     * @param {number} share 0 to 1
     */
    mix(other: Pose, share: number): void;
    /**
     * Returns the positions [J][3] of all joints: those that were sent, or computed from the rotations.
     *
     * @param {Float32Array} [out]
     */
    worldPositions(out?: Float32Array): Float32Array<ArrayBufferLike>;
    /**
     * Puts three.js bones into this pose.
     *
     * @param {Target} target a loaded model, a skeleton, or a list of bones; their names are those of the joints
     * @throws {RigError} if the bones do not fit the joints
     */
    apply(target: Target): void;
}
import type { Rig } from './rig.js';
import type { Frames } from './frames.js';
import type { Target } from './bones.js';
