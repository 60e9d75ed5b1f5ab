/** @typedef {'gltf' | 'unity' | 'unreal' | 'godot' | 'blender'} Axes */
/**
 * The fields of a message that describe a rig.
 *
 * @typedef {object} RigMessage
 * @property {string} bank
 * @property {string[]} joints
 * @property {number[]} parents
 * @property {number[][]} offsets
 * @property {Record<string, string | string[] | null>} roles
 */
/** A bank's joints. Parents come before their children, and the first joint is the root. */
export class Rig {
    /**
     * @param {RigMessage} message an event `welcome` or `bank`, a stream's header, or a skeleton and its bank
     * @param {Axes} axes of the offsets, and of everything that is posed with them
     */
    constructor(message: RigMessage, axes: Axes);
    axes: Axes;
    /** Digest of the bank. */
    bank: string;
    /** Names of the joints. */
    joints: string[];
    /** Index of each joint's parent; -1 for the root. */
    parents: Int32Array<ArrayBuffer>;
    /** Where each joint is in its parent's frame, [J][3]. */
    offsets: Float64Array<ArrayBuffer>;
    /** Name of the joint or joints of each role, as `hips` and `left_arm`. */
    roles: Record<string, string | string[] | null>;
    scratch: Float64Array<ArrayBuffer>;
    /**
     * Computes where all joints are.
     *
     * @param {ArrayLike<number>} root position of the root, [3]
     * @param {ArrayLike<number>} rotations of the joints in their parents' frames, [J][4]
     * @param {Float32Array} out receives positions, [J][3]
     */
    worldPositions(root: ArrayLike<number>, rotations: ArrayLike<number>, out: Float32Array): void;
}
export type Axes = "gltf" | "unity" | "unreal" | "godot" | "blender";
/**
 * The fields of a message that describe a rig.
 */
export type RigMessage = {
    bank: string;
    joints: string[];
    parents: number[];
    offsets: number[][];
    roles: Record<string, string | string[] | null>;
};
