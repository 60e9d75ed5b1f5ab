/** @import { Player } from '../player.js' */
/** @import { State } from '../state.js' */

const TYPE = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm']
  .find((type) => globalThis.MediaRecorder?.isTypeSupported(type) && 'captureStream' in HTMLCanvasElement.prototype);
const BITS = 12e6; // a second

/** Records the canvas while the repeated range plays once, in real time: a slow machine records fewer pictures. */
export class Recorder {
  static isPossible = TYPE !== undefined;
  #isStopped = false;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Player} player
   * @param {State} state
   */
  constructor(canvas, player, state) {
    this.canvas = canvas;
    this.player = player;
    this.state = state;
  }

  /** Ends the recording early and keeps what was recorded. */
  stop() {
    this.#isStopped = true;
  }

  /**
   * @param {(share: number) => void} onProgress
   * @returns {Promise<Blob>}
   */
  async record(onProgress) {
    const { player, state } = this;
    const before = { playing: state.values.playing, speed: state.values.speed };
    const [from, to] = player.range;
    const stream = this.canvas.captureStream(60);
    const recorder = new MediaRecorder(stream, { mimeType: TYPE, videoBitsPerSecond: BITS });
    /** @type {Blob[]} */
    const parts = [];
    recorder.ondataavailable = ({ data }) => parts.push(data);
    const ended = new Promise((resolve, reject) => {
      recorder.onstop = resolve;
      recorder.onerror = () => reject(new Error('the browser could not record the canvas'));
    });
    player.seek(from);
    await picture();
    await picture(); // the canvas shows the first frame
    recorder.start(1000);
    state.set({ playing: true, speed: Math.abs(before.speed) });
    let last = from;
    while (!this.#isStopped && recorder.state === 'recording') {
      await picture();
      if (player.time < last - 1e-6 || player.time >= to) break; // it begins again
      last = player.time;
      onProgress(to > from ? (last - from) / (to - from) : 1);
    }
    if (recorder.state !== 'inactive') recorder.stop();
    await ended;
    for (const track of stream.getTracks()) track.stop();
    state.set(before);
    return new Blob(parts, { type: 'video/webm' });
  }
}

function picture() {
  return new Promise((resolve) => requestAnimationFrame(resolve));
}
