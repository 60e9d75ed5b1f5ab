/**
 * An event of characters: `ids` are the characters, and `frame` is the first frame that shows it.
 */
export type Happened = {
    event: string;
    ids: number[];
    frame: number;
};
export type BankEvent = RigMessage & {
    clips: Record<string, {
        rate: number;
        duration: number;
    }>;
};
/**
 * The events of a connection: the service's, under the protocol's names, and this client's own.
 */
export type EventMap = {
    /**
     * the service has greeted, at first and again
     */
    welcome: BankEvent & {
        protocol: number;
        max_characters: number;
    };
    /**
     * from `frame` on, frames are of another bank
     */
    bank: BankEvent & {
        frame: number;
    };
    /**
     * a newer bank misses clips that are played here
     */
    bank_kept: {
        bank: string;
        missing: string[];
    };
    /**
     * the service stops
     */
    closing: {
        reason: string;
    };
    action_began: Happened & {
        action: string;
    };
    action_ended: Happened & {
        action: string;
    };
    locomotion_ended: Happened;
    left_down: Happened;
    left_up: Happened;
    right_down: Happened;
    right_up: Happened;
    stride: Happened;
    /**
     * a message of frames has arrived
     */
    frames: Frames;
    /**
     * the connection was lost; it is opened again in `retry` seconds
     */
    disconnected: {
        error: Error;
        retry: number;
    };
    /**
     * the characters are there again, but
     * for `failed`
     */
    reconnected: {
        failed: {
            character: Character;
            error: RefusedError;
        }[];
    };
    /**
     * the connection was closed or refused, or has nothing to do; it is not opened again
     * before the next command
     */
    closed: {
        error: Error;
    };
    /**
     * a message was not what the protocol describes, and was dropped
     */
    error: FormatError;
};
import type { RigMessage } from './rig.js';
import type { Frames } from './frames.js';
import type { Character } from './character.js';
import type { RefusedError } from './errors.js';
import type { FormatError } from './errors.js';
