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
export function address(url, path, query) {
  const found = new URL(url);
  found.protocol = found.protocol.replace(/^ws/, 'http');
  found.pathname = found.pathname.replace(/\/?$/, path);
  for (const [key, value] of Object.entries(query)) {
    if (value !== undefined) found.searchParams.set(key, String(value));
  }
  return found;
}
