export { Character } from "./source/character.js";
export { Motion } from "./source/motion.js";
export { Frames } from "./source/frames.js";
export { Pose } from "./source/pose.js";
export { Rig } from "./source/rig.js";
export { decode } from "./source/msgpack.js";
export { connect, Connection } from "./source/connection.js";
export { splice, stream } from "./source/http.js";
export { ConnectionLostError, FormatError, MotionSpliceError, RefusedError, RigError } from "./source/errors.js";
