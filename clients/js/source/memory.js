/** @import { Command, Position } from './commands.js' */
/** @import { Placed } from './ground.js' */
/** @import { Held } from './playback.js' */

/** What a client remembers of a character: the commands that make it again on a new connection, and where it jumps. */
export class Memory {
  /** @type {Command | undefined} */
  wear = undefined;
  /** @type {Command | undefined} */
  act = undefined;

  /** @type {Command | undefined} */
  look = undefined;
  /** What each part aims at. @type {Map<unknown, Command>} */
  aims = new Map();

  /**
   * @param {Command} created
   * @param {number} id
   * @param {number} frame the first one that has the character
   */
  constructor(created, id, frame) {
    this.id = id;
    /** @type {Command} */
    this.create = { ...created, id };
    /** @type {Placed} */
    this.placed = { number: frame, ground: groundOf(created) };
    /** Frames in which the character jumps to another place. */
    this.jumps = [frame];
  }

  /**
   * Notes a command that the service has done.
   *
   * @param {Command} done
   * @param {number} frame the first one that shows it
   */
  note(done, frame) {
    const { do: name, id, time, blend, curve, ...values } = done;
    if (name === 'play') this.create = { ...this.create, loop: true, ...values };
    else if (name === 'mix') this.create.locomotion = values.weights;
    else if (['speed', 'in_place', 'lock_feet'].includes(name)) Object.assign(this.create, values);
    else if (name === 'act') this.act = { ...done, id: this.id };
    else if (name === 'weight' && this.act) this.act.weight = values.weight;
    else if (name === 'stop') this.act = undefined;
    else if (name === 'wear') this.wear = values.hands === null ? undefined : { ...done, id: this.id };
    else if (name === 'look') this.look = ends(values) ? undefined : { ...done, id: this.id };
    else if (name === 'aim' && ends(values)) this.aims.clear();
    else if (name === 'aim') this.aims.set(values.part ?? 'chest', { ...done, id: this.id });
    else if (name === 'place') this.placed = { number: frame, ground: groundOf(done) };
    if (name === 'place' || name === 'in_place') this.jumps.push(frame);
  }

  /**
   * Returns the jumps after a frame, and forgets earlier ones.
   *
   * @param {number} number
   */
  jumpsAfter(number) {
    if (this.jumps.length) this.jumps = this.jumps.filter((frame) => frame > number);
    return this.jumps;
  }

  /**
   * Notes where the character is when the connection is lost.
   *
   * @param {Held | undefined} last the last frame that was received
   */
  rest(last) {
    const row = last?.frames.rowOf(this.id);
    if (last && row !== undefined) this.placed.ground = last.grounds.slice(4 * row, 4 * row + 4);
  }

  /**
   * Returns the commands that make the character again. An action that plays once is not begun again.
   *
   * @returns {Command[]}
   */
  again() {
    const [x, y, z, heading] = Array.from(this.placed.ground);
    const { time, ...create } = this.create;
    /** @type {Command[]} */
    const commands = [{ ...create, do: 'create', position: [x, y, z], heading }];
    if (this.wear) commands.push(this.wear);
    if (this.look) commands.push(this.look);
    commands.push(...this.aims.values());
    if (this.act && this.act.loop !== false) {
      const { when, start, ...act } = this.act;
      commands.push({ ...act, do: 'act' });
    }
    return commands;
  }

  /**
   * Notes that the character was made again.
   *
   * @param {number} frame the first one that has it
   */
  begin(frame) {
    this.placed = { number: frame, ground: this.placed.ground };
    this.jumps = [frame];
  }
}

/** Whether a command `look` or `aim` ends it. @param {{ point?: unknown, direction?: unknown }} values */
function ends({ point, direction }) {
  return point === null || direction === null;
}

/** @param {Command} values */
function groundOf({ position = [0, 0, 0], heading = 0 }) {
  return [.../** @type {Position} */ (position), /** @type {number} */ (heading)];
}
