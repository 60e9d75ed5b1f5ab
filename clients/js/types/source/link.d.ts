/** A WebSocket that is opened again when it is lost, after longer and longer pauses. */
export class Link {
    /**
     * @param {WebSocketClass} type
     * @param {string[]} protocols
     * @param {Hooks} hooks
     */
    constructor(type: WebSocketClass, protocols: string[], hooks: Hooks);
    /** @type {WebSocket | undefined} */
    socket: WebSocket | undefined;
    isReady: boolean;
    isIdle: boolean;
    isClosed: boolean;
    tries: number;
    heard: number;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    timer: ReturnType<typeof setTimeout> | undefined;
    /** @type {ReturnType<typeof setInterval> | undefined} */
    watch: ReturnType<typeof setInterval> | undefined;
    /** @type {{ resolve: () => void, reject: (error: Error) => void }[]} */
    waiting: {
        resolve: () => void;
        reject: (error: Error) => void;
    }[];
    type: WebSocketClass;
    protocols: string[];
    hooks: Hooks;
    /**
     * Resolves once the service has greeted.
     *
     * @returns {Promise<void>}
     */
    open(): Promise<void>;
    connect(): void;
    /** To be called when the service has greeted. */
    greeted(): void;
    /**
     * @param {string} text
     */
    send(text: string): void;
    /**
     * Closes the connection for good.
     *
     * @param {number} [code]
     * @param {string} [reason]
     */
    close(code?: number, reason?: string): void;
    /**
     * @param {number} code
     * @param {string} reason
     */
    drop(code: number, reason: string): void;
    /** Returns the next pause in seconds. Part of it is random, so that clients do not come back all at once. */
    pause(): number;
}
/**
 * What a link calls.
 */
export type Hooks = {
    /**
     * to connect to
     */
    url: () => URL;
    received: (data: string | ArrayBuffer) => void;
    /**
     * seconds without a message after which the connection is lost
     */
    patience: () => number;
    /**
     * `retry`: seconds until it is opened
     * again; undefined if it is not
     */
    lost: (error: ConnectionLostError, retry: number | undefined) => void;
};
export type WebSocketClass = new (url: string, protocols: string[]) => WebSocket;
import { ConnectionLostError } from './errors.js';
