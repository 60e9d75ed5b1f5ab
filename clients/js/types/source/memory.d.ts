/** @import { Command, Position } from './commands.js' */
/** @import { Placed } from './ground.js' */
/** @import { Held } from './playback.js' */
/** What a client remembers of a character: the commands that make it again on a new connection, and where it jumps. */
export class Memory {
    /**
     * @param {Command} created
     * @param {number} id
     * @param {number} frame the first one that has the character
     */
    constructor(created: Command, id: number, frame: number);
    /** @type {Command | undefined} */
    wear: Command | undefined;
    /** @type {Command | undefined} */
    act: Command | undefined;
    id: number;
    /** @type {Command} */
    create: Command;
    /** @type {Placed} */
    placed: Placed;
    /** Frames in which the character jumps to another place. */
    jumps: number[];
    /**
     * Notes a command that the service has done.
     *
     * @param {Command} done
     * @param {number} frame the first one that shows it
     */
    note(done: Command, frame: number): void;
    /**
     * Returns the jumps after a frame, and forgets earlier ones.
     *
     * @param {number} number
     */
    jumpsAfter(number: number): number[];
    /**
     * Notes where the character is when the connection is lost.
     *
     * @param {Held | undefined} last the last frame that was received
     */
    rest(last: Held | undefined): void;
    /**
     * Returns the commands that make the character again. An action that plays once is not begun again.
     *
     * @returns {Command[]}
     */
    again(): Command[];
    /**
     * Notes that the character was made again.
     *
     * @param {number} frame the first one that has it
     */
    begin(frame: number): void;
}
import type { Command } from './commands.js';
import type { Placed } from './ground.js';
import type { Held } from './playback.js';
