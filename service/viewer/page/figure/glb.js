/** The container of a GLB file, which a VRM file is too. */

export const FLOAT = 5126; // component type of an accessor
const [MAGIC, JSON_CHUNK, BINARY_CHUNK] = [0x46546c67, 0x4e4f534a, 0x004e4942];
const MOST = 256e6; // bytes: a browser's tab has to hold them several times

/** Why a file cannot be shown as a character: one sentence for the user. */
export class CharacterError extends Error {}

/** @typedef {Record<string, any>} Document the JSON of a glTF file */

/**
 * @param {Uint8Array} bytes
 * @returns {{ document: Document, binary: Uint8Array }}
 * @throws {CharacterError}
 */
export function openGlb(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 20 || view.getUint32(0, true) !== MAGIC) throw new CharacterError('This is not a GLB or VRM file.');
  if (view.getUint32(4, true) !== 2) throw new CharacterError('This is a GLB file of an old version. Export it as glTF 2.0.');
  if (bytes.length > MOST) throw new CharacterError(`The file has ${Math.round(bytes.length / 1e6)} MB, more than ${MOST / 1e6} MB.`);
  let text;
  /** @type {Uint8Array} */
  let binary = new Uint8Array(0);
  for (let at = 12; at + 8 <= bytes.length;) {
    const [length, kind] = [view.getUint32(at, true), view.getUint32(at + 4, true)];
    if (at + 8 + length > bytes.length) throw new CharacterError('The file is cut short. Copy or export it again.');
    const chunk = bytes.subarray(at + 8, at + 8 + length);
    if (kind === JSON_CHUNK) text ??= new TextDecoder().decode(chunk);
    if (kind === BINARY_CHUNK && !binary.length) binary = chunk;
    at += 8 + length;
  }
  try {
    const document = JSON.parse(text ?? '');
    if (typeof document === 'object' && document) return { document, binary };
  } catch { /* the sentence below */ }
  throw new CharacterError('The file is damaged: its JSON cannot be read.');
}

/**
 * @param {Document} document
 * @param {Uint8Array} binary
 */
export function writeGlb(document, binary) {
  const text = new TextEncoder().encode(JSON.stringify(document));
  const [textLength, binaryLength] = [padded(text.length), padded(binary.length)];
  const bytes = new Uint8Array(28 + textLength + binaryLength);
  const view = new DataView(bytes.buffer);
  [MAGIC, 2, bytes.length, textLength, JSON_CHUNK].forEach((number, place) => view.setUint32(4 * place, number, true));
  bytes.set(text, 20);
  bytes.fill(0x20, 20 + text.length, 20 + textLength);
  view.setUint32(20 + textLength, binaryLength, true);
  view.setUint32(24 + textLength, BINARY_CHUNK, true);
  bytes.set(binary, 28 + textLength);
  return bytes;
}

/** Returns a length rounded up to whole words of four bytes. @param {number} length */
export function padded(length) {
  return length + (-length & 3);
}
