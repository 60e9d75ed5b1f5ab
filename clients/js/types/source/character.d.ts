/** @import { ActOptions, Command, Fade, Locomotion, PlayOptions, Position, WearOptions } from './commands.js' */
/** @import { Connection } from './connection.js' */
/** @import { Target } from './bones.js' */
/**
 * A character of a connection. Commands return a promise of the number of the first frame that shows them. It is
 * rejected with a RefusedError if the service refuses, and with a ConnectionLostError if there is no connection.
 */
export class Character {
    /**
     * @param {Connection} connection
     * @param {Command} created
     * @param {number} id
     * @param {number} frame the first one that has it
     */
    constructor(connection: Connection, created: Command, id: number, frame: number);
    connection: Connection;
    id: number;
    memory: Memory;
    row: number;
    /** @type {Pose | undefined} */
    shown: Pose | undefined;
    /** @type {Pose | undefined} */
    next: Pose | undefined;
    /**
     * Fades to another locomotion, in step.
     *
     * @param {Locomotion} locomotion
     * @param {PlayOptions} [options]
     */
    play(locomotion: Locomotion, options?: PlayOptions): Promise<number>;
    /**
     * Changes the weights of the mix.
     *
     * @param {Record<string, number>} weights
     */
    mix(weights: Record<string, number>): Promise<number>;
    /**
     * Begins an action, or replaces the current one.
     *
     * @param {string} action
     * @param {ActOptions} [options]
     */
    act(action: string, options?: ActOptions): Promise<number>;
    /**
     * Sets how much of the newest action is visible, 0 to 1.
     *
     * @param {number} weight
     */
    weight(weight: number): Promise<number>;
    /**
     * Fades the action out.
     *
     * @param {Fade} [options]
     */
    stop(options?: Fade): Promise<number>;
    /**
     * Sets the hands layer; null restores the clips' own hands.
     *
     * @param {string | null} hands
     * @param {WearOptions} [options]
     */
    wear(hands: string | null, options?: WearOptions): Promise<number>;
    /**
     * Sets the playback speed, 0 to 8.
     *
     * @param {number} speed
     */
    speed(speed: number): Promise<number>;
    /**
     * Moves the character at once.
     *
     * @param {Position} position
     * @param {{ heading?: number }} [options]
     */
    place(position: Position, options?: {
        heading?: number;
    }): Promise<number>;
    /**
     * Keeps the character at the origin, or releases it.
     *
     * @param {boolean} [inPlace]
     */
    inPlace(inPlace?: boolean): Promise<number>;
    /** Removes the character. */
    remove(): Promise<number>;
    /**
     * @param {string} name
     * @param {object} values
     */
    do(name: string, values: object): Promise<number>;
    /**
     * Returns the pose to show now, between two frames; undefined before the first one. The next call changes it. While
     * there is no connection, the last pose is returned.
     */
    pose(): Pose | undefined;
    /**
     * Puts three.js bones into the pose to show now. Returns false before the first frame.
     *
     * @param {Target} target
     */
    apply(target: Target): boolean;
}
import type { Connection } from './connection.js';
import { Memory } from './memory.js';
import { Pose } from './pose.js';
import type { Locomotion } from './commands.js';
import type { PlayOptions } from './commands.js';
import type { ActOptions } from './commands.js';
import type { Fade } from './commands.js';
import type { WearOptions } from './commands.js';
import type { Position } from './commands.js';
import type { Target } from './bones.js';
import type { Command } from './commands.js';
