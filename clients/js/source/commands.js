/**
 * The values of commands, as in the protocol but for the case of names: `blendOut` is `blend_out` there.
 *
 * @typedef {string | Record<string, number>} Locomotion a clip, or a mix of clips by weight
 * @typedef {'linear' | 'smooth' | 'ease_in' | 'ease_out'} Curve
 * @typedef {'now' | 'phase' | 'left_foot' | 'right_foot' | 'foot'} When
 * @typedef {'upper_body' | 'left_arm' | 'right_arm' | 'arms' | 'head'} Mask
 * @typedef {'relative' | 'absolute' | 'running' | 'off'} Posture
 * @typedef {readonly [number, number, number]} Position
 *
 * @typedef {{ blend?: number, curve?: Curve }} Fade
 * @typedef {{ time?: number, loop?: boolean, speed?: number, position?: Position, heading?: number, inPlace?: boolean,
 *   lockFeet?: boolean }} CreateOptions
 * @typedef {{ time?: number, loop?: boolean } & Fade} PlayOptions
 * @typedef {{ when?: When, start?: number, blendOut?: number, weight?: number, loop?: boolean,
 *   ownClock?: boolean | readonly [number, number], mask?: Mask, method?: 'splice' | 'naive', posture?: Posture } & Fade} ActOptions
 * @typedef {{ weight?: number } & Fade} WearOptions
 * @typedef {{ point: Position } | { direction: Position }} AimTarget
 * @typedef {{ blend?: number, weight?: number, steady?: number, maxYaw?: number, maxPitch?: number }} TargetOptions
 * @typedef {{ spine?: number } & TargetOptions} LookOptions
 * @typedef {{ part?: 'chest' | 'left_arm' | 'right_arm' } & TargetOptions} AimOptions
 * @typedef {'action_began' | 'action_ended' | 'locomotion_ended' | 'left_down' | 'left_up' | 'right_down' | 'right_up' | 'stride'} CharacterEvent
 * @typedef {'vmc' | 'livelink'} Receiver
 * @typedef {{ rate?: number, ahead?: number, events?: readonly CharacterEvent[] }} Settings
 */

/**
 * A command, as the protocol describes it.
 *
 * @typedef {{ do: string, id?: number | readonly number[], [key: string]: unknown }} Command
 */

/**
 * Returns a command.
 *
 * @param {string} name
 * @param {object} values
 * @returns {Command}
 */
export function command(name, values) {
  const entries = Object.entries(values).filter(([, value]) => value !== undefined);
  return { do: name, ...Object.fromEntries(entries.map(([key, value]) => [key.replace(/[A-Z]/g, (big) => `_${big.toLowerCase()}`), value])) };
}

/**
 * Returns the characters that a command is for.
 *
 * @param {Command} one
 * @returns {readonly number[]}
 */
export function idsOf({ id }) {
  return id === undefined ? [] : typeof id === 'number' ? [id] : id;
}
