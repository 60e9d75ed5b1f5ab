import { matcher } from './words.js';

/**
 * A clip of the bank, as `/v1/clips` lists it.
 *
 * @typedef {object} Clip
 * @property {string} name
 * @property {'locomotion' | 'action'} kind
 * @property {string[]} tags
 * @property {number} duration seconds
 * @property {number} rate frames per second
 * @property {number} cycles strides
 * @property {number} loop strides that repeat; 0: none
 * @property {string} neutral
 * @property {boolean} stands whether it is an action without a gait, which plays at its own speed
 * @property {string[]} uses parts of the upper body that such an action uses
 * @property {string[]} hands hands clips that can be laid on it
 * @property {{ left: [number, number][], right: [number, number][] }} contacts seconds of each stance
 * @property {number} mean_mismatch metres
 * @property {number} worst_mismatch metres
 * @property {string[]} warnings
 * @property {string[]} notes
 */

/**
 * @typedef {object} Server
 * @property {string} version
 * @property {string} bank digest
 * @property {boolean} uploads
 * @property {boolean} report
 * @property {Record<string, number>} limits
 */

/** What the service has: its clips, and what it allows. */
export class Catalogue {
  /**
   * @param {Server} server
   * @param {string} baseline
   * @param {Clip[]} clips
   */
  constructor(server, baseline, clips) {
    this.server = server;
    this.baseline = baseline;
    this.clips = new Map(clips.map((clip) => [clip.name, clip]));
  }

  /**
   * @param {import('./service.js').Service} service
   * @returns {Promise<Catalogue>}
   */
  static async load(service) {
    const [server, bank, clips] = await Promise.all(['server', 'bank', 'clips'].map((name) => service.json(`/v1/${name}`)));
    return new Catalogue(server, bank.baseline, clips);
  }

  /**
   * Returns the clips whose name or tags contain all words of a text.
   *
   * @param {string} text
   */
  search(text) {
    const matches = matcher(text);
    return [...this.clips.values()].filter((clip) => matches([clip.name, ...clip.tags].join(' ')));
  }
}
