// Rigs for tests: the built-in one, one with fingers, one without toes, and one whose limbs are all bound along X.
import { Rig } from '../page/vendor/motionsplice.js';

/**
 * @param {[string, string, number[]][]} joints name, parent and offset of each
 * @param {Record<string, string | string[] | null>} roles
 */
function rigOf(joints, roles) {
  const names = joints.map(([name]) => name);
  return new Rig({ bank: 'test', joints: names, parents: joints.map(([, parent]) => names.indexOf(parent)), offsets: joints.map(([, , offset]) => offset), roles }, 'gltf');
}

const ROLES = { root: 'Hips', pelvis: 'Spine', spine: ['Chest'], neck: 'Neck', head: 'Head', left_toe: null, right_toe: null };

/** @param {string} half @param {number} sign @param {Record<string, number[]>} places */
function limbs(half, sign, { arm, elbow, wrist, hip, knee, ankle, toe }) {
  const mirrored = (/** @type {number[]} */ place) => [sign * place[0], place[1], place[2]];
  const joints = [
    [`${half}Arm`, 'Chest', arm], [`${half}ForeArm`, `${half}Arm`, elbow], [`${half}Hand`, `${half}ForeArm`, wrist],
    [`${half}UpLeg`, 'Hips', hip], [`${half}Leg`, `${half}UpLeg`, knee], [`${half}Foot`, `${half}Leg`, ankle],
    ...(toe ? [[`${half}Toe`, `${half}Foot`, toe]] : []),
  ].map(([name, parent, place]) => [name, parent, mirrored(place)]);
  const low = half.toLowerCase();
  const roles = {
    [`${low}_shoulder`]: `${half}Arm`, [`${low}_elbow`]: `${half}ForeArm`, [`${low}_wrist`]: `${half}Hand`,
    [`${low}_hip`]: `${half}UpLeg`, [`${low}_knee`]: `${half}Leg`, [`${low}_ankle`]: `${half}Foot`, ...(toe ? { [`${low}_toe`]: `${half}Toe` } : {}),
  };
  return { joints, roles };
}

/** @param {(half: string, sign: number) => [string, string, number[]][]} [more] @param {boolean} [hasToes] */
function standing(more = () => [], hasToes = true) {
  const places = {
    arm: [0.185, 0.135, 0], elbow: [0.33, 0, 0], wrist: [0.26, 0, 0], hip: [0.09, -0.03, 0], knee: [0, -0.436, 0], ankle: [0, -0.438, 0],
    toe: hasToes ? [0, -0.045, 0.135] : undefined,
  };
  const [left, right] = [limbs('Left', 1, places), limbs('Right', -1, places)];
  const trunk = [['Hips', '', [0, 0, 0]], ['Spine', 'Hips', [0, 0.09, 0]], ['Chest', 'Spine', [0, 0.26, 0]], ['Neck', 'Chest', [0, 0.19, 0]], ['Head', 'Neck', [0, 0.09, 0.02]]];
  return rigOf([...trunk, ...left.joints, ...right.joints, ...more('Left', 1), ...more('Right', -1)], { ...ROLES, ...left.roles, ...right.roles });
}

/** @param {string} half @param {number} sign */
function fingers(half, sign) {
  return ['Thumb', 'Index', 'Middle', 'Pinky'].flatMap((name, index) => {
    const base = name === 'Thumb' ? [0.025 * sign, -0.01, 0.03] : [0.09 * sign, 0, 0.045 - 0.022 * index];
    return [[`${half}${name}1`, `${half}Hand`, base], [`${half}${name}2`, `${half}${name}1`, [0.04 * sign, 0, 0]], [`${half}${name}3`, `${half}${name}2`, [0.025 * sign, 0, 0]]];
  });
}

function alongX() {
  const places = { arm: [0.05, 0, 0.16], elbow: [0.25, 0, 0], wrist: [0.23, 0, 0], hip: [0, 0, 0.096], knee: [0.47, 0, 0], ankle: [0.458, 0, 0], toe: [0.118, 0.148, 0] };
  const flip = Object.fromEntries(Object.entries(places).map(([name, [x, y, z]]) => [name, [x, y, -z]]));
  const [left, right] = [limbs('Left', 1, places), limbs('Right', 1, flip)];
  const trunk = [['Hips', '', [0, 0, 0]], ['Spine', 'Hips', [0.09, 0, 0]], ['Chest', 'Spine', [0.3, 0, 0]], ['Neck', 'Chest', [0.14, 0, 0]], ['Head', 'Neck', [0.085, 0, 0]]];
  return rigOf([...trunk, ...left.joints, ...right.joints], { ...ROLES, ...left.roles, ...right.roles });
}

export const RIGS = { standing: standing(), fingers: standing(fingers), toeless: standing(undefined, false), alongX: alongX() };
