/** What a character is asked to do, for each side of the comparison: the body of `POST /v1/take`. */

/** @import { Catalogue } from './catalogue.js' */
/** @import { Values } from './state.js' */

/** @typedef {{ at: number, do: string, [key: string]: unknown }} Command */
/** @typedef {{ rate: number, frames: number, commands: Command[] }} Take */
/** @typedef {'splice' | 'naive' | 'locomotion' | 'action' | 'truth'} SideName */

/** @type {Record<SideName, { label: string, colour: string }>} */
export const SIDES = {
  splice: { label: 'Splice', colour: '#f28c28' },
  naive: { label: 'Naive', colour: '#8c8c8c' },
  locomotion: { label: 'Locomotion alone', colour: '#3f8efc' },
  action: { label: 'Action as captured', colour: '#2fae66' },
  truth: { label: 'Truth', colour: '#b064e0' },
};

/** In the order in which they are shown. */
export const SIDE_NAMES = /** @type {SideName[]} */ (Object.keys(SIDES));
export const LONGEST = 60; // seconds of a take
/** Values that turn a part of the body to the point. */
export const PARTS = /** @type {const} */ (['look', 'chest', 'left_arm', 'right_arm']);

/**
 * Returns the take of a side; undefined if there is nothing to show.
 *
 * @param {SideName} side
 * @param {Values} values
 * @param {Catalogue} catalogue
 * @returns {Take | undefined}
 */
export function takeOf(side, values, catalogue) {
  const clip = catalogue.clips.get(clipOf(side, values));
  const hasAction = catalogue.clips.has(values.action);
  if (!clip || (side === 'naive' && !hasAction)) return undefined;
  const leading = catalogue.clips.get(values.locomotion) ?? clip;
  const seconds = side === 'action' ? Math.min(LONGEST, clip.duration) : secondsOf(values, catalogue);
  const take = { rate: leading.rate, frames: Math.floor(seconds * leading.rate + 1e-6) + 1, commands: [create(side, values, catalogue)] };
  if ((side === 'splice' || side === 'naive') && hasAction) take.commands.push(act(side, values, leading.rate));
  if (isLayered(side)) take.commands.push(...layers(values));
  if (values.hands && side !== 'locomotion' && side !== 'truth') take.commands.push({ at: 0, do: 'wear', hands: values.hands, blend: 0 });
  return take;
}

/**
 * Returns how long the takes are, but for the action's own. By default as long as the locomotion, which repeats if the action is
 * longer and it can. A truth is a clip that does not repeat, so its length counts as the locomotion's.
 *
 * @param {Values} values
 * @param {Catalogue} catalogue
 */
export function secondsOf({ locomotion, second, action, at, start, length, truth }, { clips }) {
  const whole = clips.get(locomotion)?.duration ?? clips.get(truth)?.duration ?? 10;
  const repeats = [locomotion, second].every((name) => !clips.has(name) || clips.get(name)?.loop) && !clips.has(truth);
  const acting = (repeats && clips.has(action) && at + (clips.get(action)?.duration ?? 0) - start) || 0;
  return Math.min(LONGEST, length || Math.max(whole, acting));
}

/**
 * Returns the name of the clip that a side walks by.
 *
 * @param {SideName} side
 * @param {Values} values
 */
export function clipOf(side, values) {
  return side === 'action' || side === 'truth' ? values[side] : values.locomotion;
}

/**
 * Returns whether a side shows the mirror image of its clip.
 *
 * @param {SideName} side
 * @param {Values} values
 */
export function isMirrored(side, values) {
  if (side === 'truth') return false;
  return side === 'action' ? values.mirror : values.mirror_locomotion;
}

/**
 * Returns whether a side locks its feet, looks and aims. The others stay as captured, to be compared with.
 *
 * @param {SideName} side
 */
export function isLayered(side) {
  return side === 'splice' || side === 'naive';
}

/**
 * Returns the point [3] that a value of the state names, in metres; undefined if it names none.
 *
 * @param {string} text
 */
export function pointOf(text) {
  const point = text.trim().split(/\s+/).map(Number);
  return point.length === 3 && text.trim() && point.every(Number.isFinite) ? point : undefined;
}

/**
 * @param {Values} values
 * @returns {Command[]}
 */
function layers(values) {
  const point = pointOf(values.point);
  const target = { point, ...(values.turned !== 1 && { weight: values.turned }), blend: 0 };
  const turns = PARTS.filter((part) => point && values[part]).map((part) => (part === 'look' ? { at: 0, do: 'look', ...target }
    : { at: 0, do: 'aim', part, ...target, ...(part === 'chest' && values.steady && { steady: 1 }) }));
  return [...(values.lock_feet ? [{ at: 0, do: 'lock_feet', lock_feet: true }] : []), ...turns];
}

/**
 * Returns the name of a clip's mirror image if it is asked for.
 *
 * @param {string} clip
 * @param {boolean} mirrored
 */
export function named(clip, mirrored) {
  return mirrored ? `${clip}~mirror` : clip;
}

/**
 * @param {SideName} side
 * @param {Values} values
 * @param {Catalogue} catalogue
 * @returns {Command}
 */
function create(side, values, catalogue) {
  const mirrored = isMirrored(side, values);
  if (side === 'action' || side === 'truth') return { at: 0, do: 'create', locomotion: named(values[side], mirrored), loop: false };
  const [first, second] = [named(values.locomotion, mirrored), named(values.second, mirrored)];
  const isMix = catalogue.clips.has(values.second) && values.second !== values.locomotion;
  const locomotion = isMix ? { [first]: 1 - values.share, [second]: values.share } : first;
  const isLonger = secondsOf(values, catalogue) > (catalogue.clips.get(values.locomotion)?.duration ?? Infinity);
  return { at: 0, do: 'create', locomotion, loop: values.length > 0 || isLonger };
}

/**
 * @param {SideName} side
 * @param {Values} values
 * @param {number} rate
 * @returns {Command}
 */
function act(side, values, rate) {
  const { when, start, blend, weight, mask, posture } = values;
  return {
    at: Math.round(values.at * rate), do: 'act', action: named(values.action, values.mirror), when, start, blend, blend_out: blend, weight, mask, posture,
    method: side === 'naive' ? 'naive' : 'splice', loop: !values.once, ...(values.own && { own_clock: true }),
  };
}
