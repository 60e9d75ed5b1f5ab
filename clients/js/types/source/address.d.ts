/** @import { Encoding, Parts } from './frames.js' */
/** @import { Axes } from './rig.js' */
/**
 * How frames are sent.
 *
 * @typedef {object} How
 * @property {string} [token] of the service
 * @property {Axes} [axes] `gltf` if not given, which are three.js's
 * @property {Parts} [parts] `local` if not given
 * @property {Encoding} [encoding] of rotations, `float32` if not given
 */
/**
 * Returns the address of a path of the service.
 *
 * @param {string} url of the service, of the scheme http, https, ws or wss
 * @param {string} path
 * @param {object} query undefined values are left out
 */
export function address(url: string, path: string, query: object): URL;
/**
 * How frames are sent.
 */
export type How = {
    /**
     * of the service
     */
    token?: string | undefined;
    /**
     * `gltf` if not given, which are three.js's
     */
    axes?: Axes | undefined;
    /**
     * `local` if not given
     */
    parts?: Parts | undefined;
    /**
     * of rotations, `float32` if not given
     */
    encoding?: Encoding | undefined;
};
import type { Axes } from './rig.js';
import type { Parts } from './frames.js';
import type { Encoding } from './frames.js';
