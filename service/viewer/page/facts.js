/** What the timeline shows of a motion: computed from what the service has sent. */

import { distances, mean, upperBody } from './scene/differences.js';
import { tracks } from './scene/tracks.js';
import { isMirrored } from './takes.js';
import { alignedDistances, legClouds } from './timeline/distance_grid.js';

/** @import { Clip } from './catalogue.js' */
/** @import { Contacts } from './scene/stances.js' */
/** @import { Side } from './sides.js' */
/** @import { Values } from './state.js' */

/**
 * Returns when the feet stand. The clip says it, unless another clip is mixed in or the take repeats it.
 *
 * @param {Side} side
 * @param {Clip} clip
 * @param {Values} values
 * @returns {Contacts}
 */
export function contactsOf(side, clip, values) {
  const isOwn = side.name === 'action' || side.name === 'truth' || !(values.second || side.take.commands[0].loop);
  if (isOwn && isMirrored(side.name, values)) return { left: clip.contacts.right, right: clip.contacts.left };
  return isOwn ? clip.contacts : { left: stances(side, 'left'), right: stances(side, 'right') };
}

/**
 * @param {Side} side
 * @param {'left' | 'right'} foot
 */
function stances({ events, motion }, foot) {
  /** @type {[number, number][]} */
  const found = [];
  let down = 0;
  let stands = events.find(({ event }) => event.startsWith(foot))?.event === `${foot}_up`; // it has stood since the first frame
  for (const { frame, event } of events) {
    const time = frame / motion.rate;
    if (event === `${foot}_down`) [down, stands] = [time, true];
    if (event === `${foot}_up` && stands) {
      found.push([down, time]);
      stands = false;
    }
  }
  if (stands) found.push([down, motion.duration]);
  return found;
}

/**
 * Returns how far the upper bodies of two sides are apart at each frame, in metres, with the hips at one place.
 *
 * @param {Side} side
 * @param {Side} other
 */
export function differencesOf(side, other) {
  const { rig } = side.motion;
  const joints = upperBody(rig);
  const [a, b] = [tracks(side.motion), tracks(other.motion)];
  const width = 3 * rig.joints.length;
  const apart = new Float32Array(rig.joints.length);
  return Float32Array.from({ length: Math.min(a.count, b.count) }, (_, frame) => {
    const [from, to] = [width * frame, width * (frame + 1)];
    return mean(distances(a.positions.subarray(from, to), b.positions.subarray(from, to), rig, 'root', apart), joints);
  });
}

/**
 * Returns how far the legs of the locomotion and of the action are apart at the moments that the splice plays, in metres.
 *
 * @param {Side} locomotion
 * @param {Side} action
 * @param {Float32Array} actionTimes
 */
export function mismatchesOf(locomotion, action, actionTimes) {
  return alignedDistances(legClouds(locomotion.motion), legClouds(action.motion), actionTimes);
}
