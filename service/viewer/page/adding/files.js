/** Which files the service takes as new clips, and under which names. */

export const SUFFIXES = ['.bvh', '.fbx', '.glb', '.gltf', '.vrm', '.vrma', '.amc', '.asf'];
export const SKELETON = '.asf';
/** A name of a clip, without its suffix: what the service accepts. */
export const NAME = /^[A-Za-z0-9][A-Za-z0-9_+\-]{0,99}$/;

/**
 * Returns a file's name without and with its suffix, which is in lower case.
 *
 * @param {string} fileName
 */
export function parts(fileName) {
  const dot = fileName.lastIndexOf('.');
  return dot < 0 ? { stem: fileName, suffix: '' } : { stem: fileName.slice(0, dot), suffix: fileName.slice(dot).toLowerCase() };
}

/**
 * Returns a name that the service accepts, as near to the file's as possible.
 *
 * @param {string} fileName
 */
export function nameFor(fileName) {
  const plain = parts(fileName).stem.normalize('NFKD').replace(/\p{M}/gu, ''); // é becomes e
  const name = plain.replace(/[^A-Za-z0-9_+\-]+/g, '_').replace(/^[^A-Za-z0-9]+|_+$/g, '').slice(0, 100);
  return name || 'clip';
}

/**
 * Returns why a file cannot be a new clip; empty if it can, as far as its name and size say.
 *
 * @param {{ name: string, size: number }} file
 * @param {number} limit bytes
 */
export function faultOf({ name, size }, limit) {
  const { suffix } = parts(name);
  if (!SUFFIXES.includes(suffix)) return `Not a motion file. Choose ${SUFFIXES.slice(0, -1).join(', ')} or ${SKELETON}.`;
  if (size === 0) return 'The file is empty.';
  if (size > limit) return `The file has ${megabytes(size)} MB, and this service takes at most ${megabytes(limit)} MB.`;
  return '';
}

/**
 * Returns files in the order in which they are sent: skeletons before the motions that need them.
 *
 * @template {{ name: string }} One
 * @param {One[]} files
 */
export function ordered(files) {
  const rank = (/** @type {One} */ file) => Number(parts(file.name).suffix !== SKELETON);
  return [...files].sort((a, b) => rank(a) - rank(b) || a.name.localeCompare(b.name, undefined, { numeric: true }));
}

/** @param {number} bytes */
function megabytes(bytes) {
  return Number((bytes / 1e6).toPrecision(3));
}
