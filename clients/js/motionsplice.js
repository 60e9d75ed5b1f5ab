/** Plays the characters of a motionsplice service. `connect` begins; README.md has the rest on a page. */
export { connect, Connection } from './source/connection.js';
export { Character } from './source/character.js';
export { splice, stream, take } from './source/http.js';
export { Motion } from './source/motion.js';
export { Nodes } from './source/nodes.js';
export { Frames } from './source/frames.js';
export { Pose } from './source/pose.js';
export { Rig } from './source/rig.js';
export { decode } from './source/msgpack.js';
export { ConnectionLostError, FormatError, MotionSpliceError, RefusedError, RigError } from './source/errors.js';
