/**
 * Fetches a whole splice.
 *
 * @param {string} url of the service
 * @param {Splice} what
 * @param {How} [how]
 * @throws {RefusedError | ConnectionLostError | FormatError}
 */
export function splice(url: string, what: Splice, { token, axes, parts, encoding }?: How): Promise<Motion>;
/**
 * Begins a stream of a splice.
 *
 * @param {string} url of the service
 * @param {Splice & { pace?: 'fast' | 'realtime', ahead?: number }} what
 * @param {How} [how]
 * @returns {Promise<{ motion: Motion, frames: AsyncGenerator<Frames, void, void> }>} `frames` are the messages as they
 *   arrive; each is added to `motion` before
 * @throws {RefusedError | ConnectionLostError | FormatError}
 */
export function stream(url: string, what: Splice & {
    pace?: "fast" | "realtime";
    ahead?: number;
}, { token, axes, parts, encoding }?: How): Promise<{
    motion: Motion;
    frames: AsyncGenerator<Frames, void, void>;
}>;
/**
 * A splice, as the protocol's "Parameters" describe it.
 */
export type Splice = {
    /**
     * clip that gives the root and the lower body
     */
    locomotion: string;
    /**
     * clip that gives the upper body
     */
    action?: string | undefined;
    /**
     * seconds into the action
     */
    start?: number | undefined;
    method?: "splice" | "none" | "naive" | undefined;
    hands?: string | undefined;
    posture?: Posture | undefined;
    /**
     * frames per second
     */
    rate?: number | undefined;
    /**
     * number of the first frame
     */
    first?: number | undefined;
    /**
     * number of frames
     */
    count?: number | undefined;
};
import type { How } from './address.js';
import { Motion } from './motion.js';
import { Frames } from './frames.js';
import type { Posture } from './commands.js';
