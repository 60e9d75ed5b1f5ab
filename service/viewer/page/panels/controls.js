import { characterField } from '../figure/field.js';
import { isLayered, LONGEST, PARTS, secondsOf, SIDES, SIDE_NAMES } from '../takes.js';
import { BODIES, CROWDS, LAYOUTS, VIEWS } from './choices.js';
import { sidesField } from './compared.js';
import { hint, number, row, segments, select, shownIf, toggle } from './fields.js';
import { Group } from './group.js';
import { pointField } from './point.js';

/** @import { Catalogue } from '../catalogue.js' */
/** @import { Own } from '../figure/own.js' */
/** @import { State, Values } from '../state.js' */
/** @import { SideName } from '../takes.js' */

const PERCENT = { unit: '%', step: 1, most: 100, limit: 100, scale: 100 };
const MASKS = { upper_body: 'Upper body', arms: 'Both arms', left_arm: 'Left arm', right_arm: 'Right arm', head: 'Head' };
const WHENS = {
  now: 'At once', phase: 'In phase with its start', foot: 'At the next foot',
  left_foot: 'At the left foot', right_foot: 'At the right foot',
};
const AT_HELP = 'Time of the take at which the action is asked for';
const POSTURES = { relative: 'Relative', absolute: 'Absolute', running: 'Running mean', off: 'Off' };
const POSTURE_HELP = 'Relative: the locomotion\'s torso, plus what the action changes against its neutral clip. '
  + 'Absolute: the mean posture of the action. Running mean: as absolute, from the last two seconds. Off: no transfer.';

/** The right column: every other value of the state, in groups. */
export class Controls {
  /** @type {string[]} */
  #joints = [];

  /**
   * @param {HTMLElement} element
   * @param {Catalogue} catalogue
   * @param {State} state
   * @param {Own} own
   */
  constructor(element, catalogue, state, own) {
    this.catalogue = catalogue;
    this.own = own;
    this.state = state;
    this.groups = [this.#compare(), this.#action(), this.#mix(), this.#aim(), this.#camera(), this.#show(), this.#length(), this.#crowd()];
    element.replaceChildren(...this.groups.map((group) => group.element));
    state.on(() => this.#sync());
  }

  /**
   * Offers clips of another bank.
   *
   * @param {Catalogue} catalogue
   */
  reload(catalogue) {
    this.catalogue = catalogue;
    this.#sync();
  }

  /**
   * Offers joints whose curves can be shown.
   *
   * @param {string[]} names
   */
  joints(names) {
    if (names.join() === this.#joints.join()) return;
    this.#joints = names;
    this.#sync();
  }

  #sync() {
    for (const group of this.groups) group.sync();
  }

  #compare() {
    const { state } = this;
    const sides = Object.fromEntries(SIDE_NAMES.map((side) => [side, SIDES[side].label]));
    return new Group(state, 'Compare', ['show', 'layout', 'against', 'truth'], [
      sidesField(state, () => this.catalogue),
      segments(state, 'layout', 'Layout', LAYOUTS),
      select(state, 'against', 'Distance to', { '': 'Not shown', ...sides }, 'Colours the joints by their distance to this motion'),
      select(state, 'truth', 'Truth clip', () => this.#clips('None')),
      hint(state, unseenOf),
    ]);
  }

  #action() {
    const { state } = this;
    const seconds = { unit: 's', step: 0.05 };
    const length = () => this.catalogue.clips.get(state.values.action)?.duration ?? 10;
    return new Group(state, 'Action', ['mask', 'when', 'at', 'start', 'blend', 'weight', 'posture', 'mirror', 'own', 'once'], [
      select(state, 'mask', 'Drives', MASKS, 'The joints that the action drives'),
      select(state, 'posture', 'Posture', POSTURES, POSTURE_HELP),
      select(state, 'when', 'Begins', WHENS),
      number(state, 'at', 'Asked at', { ...seconds, most: () => this.#seconds(), limit: LONGEST, title: AT_HELP }),
      number(state, 'start', 'Starts from', { ...seconds, most: length, title: 'Time of the action clip from which it plays' }),
      number(state, 'blend', 'Blend', { ...seconds, most: 2, limit: 10, title: 'Time to fade in, and to fade out' }),
      number(state, 'weight', 'Weight', PERCENT),
      row(
        toggle(state, 'mirror', 'Mirror', 'Exchanges left and right of the action'),
        toggle(state, 'own', 'Own clock', 'The action plays at its own speed instead of in step'),
        toggle(state, 'once', 'Once', 'The action ends instead of repeating'),
      ),
    ], (values) => (this.catalogue.clips.has(values.action) ? '' : 'Choose an action.'));
  }

  #mix() {
    const { state } = this;
    return new Group(state, 'Locomotion', ['mirror_locomotion', 'lock_feet', 'second', 'share'], [
      row(
        toggle(state, 'mirror_locomotion', 'Mirror', 'Exchanges left and right of the locomotion'),
        toggle(state, 'lock_feet', 'Lock feet', 'A standing foot stays where it is, in the splice and in naive'),
      ),
      select(state, 'second', 'Mix in', () => this.#clips('Nothing')),
      shownIf(number(state, 'share', 'Share', { ...PERCENT, title: 'How much of the second locomotion' }),
        () => state.values.second !== ''),
      hint(state, ({ locomotion, second, share }) => (second && second !== locomotion
        ? `${Math.round(100 * (1 - share))} % ${locomotion}, ${Math.round(100 * share)} % ${second}` : '')),
    ]);
  }

  #aim() {
    const { state } = this;
    const isAiming = () => PARTS.some((part) => state.values[part]);
    return new Group(state, 'Look and aim', [...PARTS, 'steady', 'turned', 'point'], [
      row(toggle(state, 'look', 'Head'), toggle(state, 'left_arm', 'Left arm'), toggle(state, 'right_arm', 'Right arm')),
      row(
        toggle(state, 'chest', 'Chest'),
        shownIf(toggle(state, 'steady', 'Steady hands', 'The hands do not swivel about the point'), () => state.values.chest),
      ),
      ...[pointField(state), number(state, 'turned', 'Weight', PERCENT)].map((field) => shownIf(field, isAiming)),
      hint(state, () => (isAiming() ? 'Drag the point in the scene. D brings it to the character.' : '')),
    ], ({ show }) => (SIDE_NAMES.some((side) => isLayered(side) && show.split(',').includes(side)) ? '' : 'Show the splice or naive.'));
  }

  #length() {
    const { state } = this;
    return new Group(state, 'Length', ['length'], [
      number(state, 'length', 'Take', { unit: 's', step: 0.5, most: LONGEST, limit: LONGEST }),
      hint(state, ({ length }) => (length ? 'The locomotion repeats.' : `0: ${this.#lasts()}, ${this.#seconds().toFixed(1)} s`)),
    ]);
  }

  #camera() {
    const { state } = this;
    return new Group(state, 'Camera', ['view', 'follow', 'camera'], [
      segments(state, 'view', 'View', VIEWS),
      toggle(state, 'follow', 'Follow the character'),
    ]);
  }

  #show() {
    const { state } = this;
    return new Group(state, 'Show', ['body', 'trails', 'path', 'contacts', 'joint'], [
      segments(state, 'body', 'Body', BODIES),
      characterField(this.own),
      row(toggle(state, 'trails', 'Trails', 'Paths of feet and hands'), toggle(state, 'path', 'Path', 'Path of the root'),
        toggle(state, 'contacts', 'Contacts', 'Where the feet stand')),
      select(state, 'joint', 'Curves of', () => ({ '': 'No joint', ...Object.fromEntries(this.#joints.map((name) => [name, name])) })),
    ]);
  }

  #crowd() {
    const { state } = this;
    const most = this.catalogue.server.limits.max_characters ?? Infinity;
    const counts = CROWDS.filter((count) => count <= most);
    return new Group(state, 'Crowd', ['crowd'], [
      segments(state, 'crowd', 'Characters', Object.fromEntries(counts.map((count) => [count, count ? count.toLocaleString('en') : 'Off']))),
      hint(state, ({ crowd }) => (crowd ? 'Live from the WebSocket. Choose a clip to end it.' : '')),
    ]);
  }

  /** Seconds of the take. */
  #seconds() {
    return secondsOf(this.state.values, this.catalogue);
  }

  #lasts() {
    const whole = this.catalogue.clips.get(this.state.values.locomotion)?.duration ?? Infinity;
    if (this.#seconds() === LONGEST) return 'the limit of a take';
    return this.#seconds() > whole ? 'as long as the action' : 'as long as the locomotion';
  }

  /** @param {string} none */
  #clips(none) {
    return { '': none, ...Object.fromEntries([...this.catalogue.clips.keys()].map((name) => [name, name])) };
  }
}

/**
 * Returns what to do if a choice under Compare has no effect.
 *
 * @param {Values} values
 */
function unseenOf({ show, against, truth }) {
  const shown = show.split(',');
  const unseen = [truth && 'truth', against].find((side) => side && !shown.includes(side));
  if (unseen) return `Check ${SIDES[/** @type {SideName} */ (unseen)]?.label ?? unseen} to compare with it.`;
  return against && shown[0] === against ? 'The first motion that is checked is coloured: choose the distance to another one.' : '';
}
