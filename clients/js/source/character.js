import { command } from './commands.js';
import { Pose } from './pose.js';

/** @import { ActOptions, AimOptions, AimTarget, Command, Fade, Locomotion, LookOptions, PlayOptions, Position, Receiver, WearOptions } from './commands.js' */
/** @import { Memory } from './memory.js' */
/** @import { Moment } from './playback.js' */
/** @import { Target } from './rest.js' */

/**
 * A character of a connection. Commands return a promise of the number of the first frame that shows them. It is
 * rejected with a RefusedError if the service refuses, and with a ConnectionLostError if there is no connection.
 */
export class Character {
  #memory;
  #moment;
  #send;
  #row = 0;
  /** @type {Pose | undefined} */
  #shown = undefined;
  /** @type {Pose | undefined} */
  #next = undefined;

  /**
   * @param {Memory} memory
   * @param {() => Moment | undefined} moment what to show now
   * @param {(command: Command) => Promise<number>} send
   */
  constructor(memory, moment, send) {
    this.id = memory.id;
    this.#memory = memory;
    this.#moment = moment;
    this.#send = send;
  }

  /**
   * Fades to another locomotion, in step.
   *
   * @param {Locomotion} locomotion
   * @param {PlayOptions} [options]
   */
  play(locomotion, options) {
    return this.#do('play', { locomotion, ...options });
  }

  /**
   * Changes the weights of the mix.
   *
   * @param {Record<string, number>} weights
   */
  mix(weights) {
    return this.#do('mix', { weights });
  }

  /**
   * Begins an action, or replaces the current one.
   *
   * @param {string} action
   * @param {ActOptions} [options]
   */
  act(action, options) {
    return this.#do('act', { action, ...options });
  }

  /**
   * Sets how much of the newest action is visible, 0 to 1.
   *
   * @param {number} weight
   */
  weight(weight) {
    return this.#do('weight', { weight });
  }

  /**
   * Fades the action out.
   *
   * @param {Fade} [options]
   */
  stop(options) {
    return this.#do('stop', { ...options });
  }

  /**
   * Sets the hands layer; null restores the clips' own hands.
   *
   * @param {string | null} hands
   * @param {WearOptions} [options]
   */
  wear(hands, options) {
    return this.#do('wear', { hands, ...options });
  }

  /**
   * Turns head, neck and spine toward a point or a direction; null ends it.
   *
   * @param {AimTarget | null} target
   * @param {LookOptions} [options]
   */
  look(target, options) {
    return this.#do('look', { ...(target ?? { point: null }), ...options });
  }

  /**
   * Turns the chest or an arm toward a point or a direction; null ends it for all parts.
   *
   * @param {AimTarget | null} target
   * @param {AimOptions} [options]
   */
  aim(target, options) {
    return this.#do('aim', { ...(target ?? { point: null }), ...options });
  }

  /**
   * Sets the playback speed, 0 to 8.
   *
   * @param {number} speed
   */
  speed(speed) {
    return this.#do('speed', { speed });
  }

  /**
   * Moves the character at once.
   *
   * @param {Position} position
   * @param {{ heading?: number }} [options]
   */
  place(position, options) {
    return this.#do('place', { position, ...options });
  }

  /**
   * Keeps the character at the origin, or releases it.
   *
   * @param {boolean} [inPlace]
   */
  inPlace(inPlace = true) {
    return this.#do('in_place', { inPlace });
  }

  /**
   * Holds standing feet in place, or no longer.
   *
   * @param {boolean} [lockFeet]
   */
  lockFeet(lockFeet = true) {
    return this.#do('lock_feet', { lockFeet });
  }

  /**
   * Sends the character to these receivers of the service's settings, and to no others.
   *
   * @param {...Receiver} to
   */
  sendTo(...to) {
    return this.#do('send', { to });
  }

  /** Removes the character. */
  remove() {
    return this.#do('remove', {});
  }

  /**
   * @param {string} name
   * @param {object} values
   */
  #do(name, values) {
    return this.#send(command(name, { id: this.id, ...values }));
  }

  /**
   * Returns the pose to show now, between two frames; undefined before the first one. The next call changes it. While
   * there is no connection, the last pose is returned.
   */
  pose() {
    const moment = this.#moment();
    if (!moment) return this.#shown;
    const { a, b, share } = moment;
    const row = a.frames.rowOf(this.id, this.#row);
    if (row === undefined) return this.#shown;
    this.#row = row;
    this.#shown = this.#shown?.fits(a.frames) ? this.#shown : Pose.for(a.frames);
    this.#shown.read(a.frames, a.index, row);
    const jumps = this.#memory.jumpsAfter(a.number);
    const rowThen = share > 0 ? b?.frames.rowOf(this.id, row) : undefined;
    if (b && rowThen !== undefined && !jumps.some((frame) => frame <= b.number)) {
      this.#next = this.#next?.fits(b.frames) ? this.#next : Pose.for(b.frames);
      this.#next.read(b.frames, b.index, rowThen);
      this.#shown.mix(this.#next, share);
    }
    return this.#shown;
  }

  /**
   * Puts three.js bones into the pose to show now. Returns false before the first frame.
   *
   * @param {Target} target
   */
  apply(target) {
    const pose = this.pose();
    pose?.apply(target);
    return pose !== undefined;
  }
}
