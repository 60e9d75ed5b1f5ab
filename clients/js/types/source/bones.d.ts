/**
 * Returns the bones of a target that a rig moves.
 *
 * @param {Rig} rig
 * @param {Target} target
 * @throws {RigError}
 */
export function bind(rig: Rig, target: Target): Bones;
/**
 * What this module uses of three.js's Object3D and Bone.
 */
export type Node = {
    name: string;
    position: {
        x: number;
        y: number;
        z: number;
        set(x: number, y: number, z: number): unknown;
    };
    quaternion: {
        x: number;
        y: number;
        z: number;
        w: number;
        set(x: number, y: number, z: number, w: number): unknown;
    };
    scale: {
        x: number;
        y: number;
        z: number;
    };
    parent: Node | null;
    children: readonly Node[];
    isBone?: boolean | undefined;
};
export type Target = Node | {
    bones: readonly Node[];
} | readonly Node[];
import type { Rig } from './rig.js';
declare class Bones {
    /**
     * @param {Rig} rig
     * @param {Target} target
     */
    constructor(rig: Rig, target: Target);
    rig: Rig;
    /** The bone of each joint; joints that end a chain may have none. */
    joints: (Node | undefined)[];
    root: Node;
    above: {
        position: number[];
        quaternion: number[];
        scale: number;
    };
    /**
     * @param {ArrayLike<number>} root
     * @param {ArrayLike<number>} rotations
     */
    set(root: ArrayLike<number>, rotations: ArrayLike<number>): void;
}
export {};
