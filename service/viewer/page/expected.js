/** How far the splice can be trusted, in plain words. */

import { named } from './takes.js';

/** @import { Sides } from './sides.js' */
/** @import { Values } from './state.js' */

/** @typedef {{ error: number, replaced: number, gains_little: boolean }} Expectation */

/**
 * Returns the query of the splice's expectation; undefined if the service can say nothing of what is shown.
 *
 * @param {Values} values
 */
export function queryOf({ show, locomotion, second, action, start, hands, posture, mask, weight, own, mirror, mirror_locomotion }) {
  const isWhole = mask === 'upper_body' && weight === 1 && !own && (!second || second === locomotion);
  if (!action || !isWhole || !show.split(',').includes('splice')) return undefined;
  const query = new URLSearchParams({ locomotion: named(locomotion, mirror_locomotion), action: named(action, mirror), start: String(start), posture });
  if (hands) query.set('hands', hands);
  return query;
}

/**
 * @param {Expectation | null} expected
 * @returns {string}
 */
export function wordsOf(expected) {
  if (!expected) return '';
  const { error, replaced, gains_little } = expected;
  const [ours, plain] = [error, replaced].map((metres) => `${Math.round(100 * metres) || 'under 1'} cm`);
  const warning = gains_little ? ': little is gained. Try "Own clock"' : '';
  return `Expected error ${ours}, plain replacement ${plain}${warning}`;
}

/**
 * Says what to expect of the splice, if it is shown.
 *
 * @param {HTMLElement} element
 * @param {Sides} sides
 * @param {Values} values
 * @param {() => boolean} isNewest whether nothing else was asked for meanwhile
 */
export async function say(element, { service, catalogue }, values, isNewest) {
  const query = catalogue.clips.has(values.action) && queryOf(values);
  const { expected } = query ? await service.json(`/v1/expectation?${query}`) : { expected: null };
  if (!isNewest()) return;
  element.textContent = wordsOf(expected);
  element.className = expected?.gains_little ? 'fault' : '';
}
