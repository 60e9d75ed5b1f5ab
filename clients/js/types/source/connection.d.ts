/**
 * Connects to a service's characters.
 *
 * @param {string} url of the service, as `http://127.0.0.1:8000`
 * @param {How & ConnectOptions} [options]
 * @throws {ConnectionLostError} if nobody answers
 * @throws {RefusedError} if the service refuses, which it can tell web pages only
 */
export function connect(url: string, options?: How & ConnectOptions): Promise<Connection>;
/** A connection to the characters of a service. Made by `connect`. */
export class Connection {
    /**
     * @param {string} url
     * @param {How & ConnectOptions} options
     */
    constructor(url: string, { token, axes, parts, encoding, rate, ahead, WebSocket }: How & ConnectOptions);
    /**
     * The characters by their ids.
     *
     * @type {Map<number, Character>}
     */
    characters: Map<number, Character>;
    playback: Playback;
    /** @type {Map<number, Pending>} */
    pending: Map<number, Pending>;
    /** @type {Map<string, Set<(event: any) => void>>} */
    listeners: Map<string, Set<(event: any) => void>>;
    /** @type {Error | undefined} */
    refusal: Error | undefined;
    lastRef: number;
    lastId: number;
    encoding: import("./frames.js").Encoding;
    /** What was asked for, which a new connection asks for again. @type {Settings} */
    settings: Settings;
    axes: import("./rig.js").Axes;
    link: Link;
    /** The joints of the bank whose frames arrive. @type {Rig | undefined} */
    rig: Rig | undefined;
    /**
     * The clips of the bank, by name.
     *
     * @type {Record<string, { rate: number, duration: number }>}
     */
    clips: Record<string, {
        rate: number;
        duration: number;
    }>;
    /**
     * Calls a listener at each event. Returns a function that ends it.
     *
     * @template {keyof EventMap} K
     * @param {K} name
     * @param {(event: EventMap[K]) => void} listener
     */
    on<K extends keyof EventMap>(name: K, listener: (event: EventMap[K]) => void): () => undefined;
    /**
     * Creates a character.
     *
     * @param {Locomotion} locomotion
     * @param {CreateOptions & { id?: number }} [options] `id`: a free one if not given
     */
    create(locomotion: Locomotion, { id, ...options }?: CreateOptions & {
        id?: number;
    }): Promise<Character>;
    /**
     * Changes the connection's rate, look-ahead or events.
     *
     * @param {Settings} settings
     */
    set(settings: Settings): Promise<number>;
    /**
     * Sends commands as the protocol has them. A list is done at the same frame, or not at all.
     *
     * @param {Command | readonly Command[]} commands
     * @returns {Promise<number>} number of the first frame that shows them
     * @throws {RefusedError | ConnectionLostError}
     */
    send(commands: Command | readonly Command[]): Promise<number>;
    /** Closes the connection for good. */
    close(): void;
    /** Between which frames, and where between them, characters are to be shown now; undefined before the first. */
    moment(): {
        a: import("./playback.js").Held;
        b: import("./playback.js").Held | undefined;
        share: number;
    } | undefined;
    /**
     * @param {Command[]} listed
     * @param {(frame: number) => void} note
     * @returns {Promise<number>}
     */
    ask(listed: Command[], note: (frame: number) => void): Promise<number>;
    freeId(): number;
    /**
     * @param {Command} done
     * @param {number} frame
     */
    note(done: Command, frame: number): void;
    /** @param {string | ArrayBuffer} data */
    received(data: string | ArrayBuffer): void;
    /** @param {unknown} message */
    arrived(message: unknown): void;
    /** @param {any} event */
    happened(event: any): void;
    /** @param {{ event: string, ref: unknown, frame: number, type: string, detail: string }} reply */
    replied({ event, ref, frame, type, detail }: {
        event: string;
        ref: unknown;
        frame: number;
        type: string;
        detail: string;
    }): void;
    /**
     * @param {ConnectionLostError} error
     * @param {number | undefined} retry
     */
    lost(error: ConnectionLostError, retry: number | undefined): void;
    /** Makes the characters again on a new connection. */
    restore(): Promise<void>;
    /**
     * @param {string} name
     * @param {any} event
     */
    emit(name: string, event: any): void;
}
export type ConnectOptions = {
    /**
     * frames per second, 60 if not given
     */
    rate?: number | undefined;
    /**
     * frames in a message, 1 if not given
     */
    ahead?: number | undefined;
    /**
     * for Node before 22, as the package `ws` has it
     */
    WebSocket?: WebSocketClass | undefined;
};
/**
 * a message without a reply
 */
export type Pending = {
    /**
     * called before frames that the message changes arrive
     */
    note: (frame: number) => void;
    resolve: (frame: number) => void;
    reject: (error: Error) => void;
};
import type { How } from './address.js';
import { Character } from './character.js';
import { Playback } from './playback.js';
import type { Settings } from './commands.js';
import { Link } from './link.js';
import { Rig } from './rig.js';
import type { EventMap } from './events.js';
import type { Locomotion } from './commands.js';
import type { CreateOptions } from './commands.js';
import type { Command } from './commands.js';
import { ConnectionLostError } from './errors.js';
import type { WebSocketClass } from './link.js';
