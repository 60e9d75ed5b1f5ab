import { CharacterError } from './glb.js';

/** @import { Document } from './glb.js' */

const DRACO = 'KHR_draco_mesh_compression';
const COMPRESSED = {
  [DRACO]: 'Its meshes are compressed with Draco. Export it without compression.',
  EXT_meshopt_compression: 'Its data are compressed with meshopt. Export it without compression.',
  KHR_meshopt_compression: 'Its data are compressed with meshopt. Export it without compression.',
  KHR_texture_basisu: 'Its textures are compressed as KTX2. Export it with PNG or JPEG.',
};
const WHITE = 'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAsTj2FAAAAABJRU5ErkJggg==';

/**
 * Checks that a file needs nothing that the page cannot read.
 *
 * @param {Document} document
 * @throws {CharacterError}
 */
export function checkReadable({ buffers = [], extensionsRequired = [], extensionsUsed = [] }) {
  if (buffers.length > 1 || buffers[0]?.uri !== undefined) throw new CharacterError('Its data are in other files. Export it as one GLB file.');
  for (const [name, problem] of Object.entries(COMPRESSED)) if (extensionsRequired.includes(name)) throw new CharacterError(problem);
  if (extensionsUsed.includes(DRACO)) throw new CharacterError(COMPRESSED[DRACO]); // three.js reads none without its decoder
}

/**
 * Returns the document with its pictures at addresses that the page may load: those in the text as blobs, and white in place of
 * those in other files.
 *
 * @param {Document} document
 * @param {string[]} urls receives the addresses that are made
 */
export function withOwnPictures(document, urls) {
  if (!document.images?.some((/** @type {any} */ { uri }) => uri !== undefined)) return document;
  const images = document.images.map((/** @type {any} */ image) => {
    if (image.uri === undefined) return image;
    const [, type = 'image/png', data = WHITE] = /^data:(image\/[\w+.-]+);base64,([A-Za-z0-9+/=]+)$/.exec(image.uri) ?? [];
    const url = URL.createObjectURL(new Blob([Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0))], { type }));
    urls.push(url);
    return { ...image, uri: url, mimeType: type };
  });
  return { ...document, images };
}
