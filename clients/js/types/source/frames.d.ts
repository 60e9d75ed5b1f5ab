/** A message of frames. Its arrays are views into the message. F is the number of frames, n of characters, J of joints. */
export class Frames {
    /**
     * @param {any} message the decoded map
     * @param {Rig} rig of the bank that made the frames
     * @param {Encoding} encoding
     * @throws {FormatError} if the message does not fit the rig and the encoding
     */
    constructor(message: any, rig: Rig, encoding: Encoding);
    rig: Rig;
    /** Number of the first frame. */
    frame: number;
    /** F */
    count: number;
    /** Frames per second. */
    rate: number;
    /** When the first frame is due, in seconds since 1970 by the service's clock; of characters only. */
    time: number | undefined;
    /** The characters [n]; undefined for a splice or a stream, which have one. */
    ids: Uint32Array<ArrayBuffer> | undefined;
    /** n */
    characters: number;
    /** [F][n][3] */
    rootPositions: Float32Array<ArrayBuffer>;
    /** [F][n][J][4], if the parts include local rotations; in int16 they are to be divided by 32767 and normalised */
    rotations: Int16Array<ArrayBuffer> | Float32Array<ArrayBuffer> | undefined;
    /** [F][n][J][3], if the parts include world positions */
    worldPositions: Float32Array<ArrayBuffer> | undefined;
    /** [F][n][3], with `deltas`: what root motion has added since the frame before, in the character's own heading */
    rootSteps: Float32Array<ArrayBuffer> | undefined;
    /** [F][n], with `deltas`: radians that root motion has turned since the frame before */
    rootTurns: Float32Array<ArrayBuffer> | undefined;
    /** @type {Map<number, number> | undefined} */
    rowsById: Map<number, number> | undefined;
    /**
     * Returns the row of a character, or undefined. Characters mostly keep their rows, so that one is tried first.
     *
     * @param {number} id
     * @param {number} [before]
     */
    rowOf(id: number, before?: number): number | undefined;
    /**
     * Copies the root's position and the rotations of one character at one frame.
     *
     * @param {number} number of the frame in this message, from 0
     * @param {number} row
     * @param {Float32Array} root receives [3]
     * @param {Float32Array | undefined} rotations receives [J][4], of length 1
     * @param {Float32Array | undefined} positions receives the world positions [J][3]
     */
    copy(number: number, row: number, root: Float32Array, rotations: Float32Array | undefined, positions: Float32Array | undefined): void;
}
export type Encoding = "float32" | "int16";
export type Parts = "local" | "world" | "both";
import type { Rig } from './rig.js';
