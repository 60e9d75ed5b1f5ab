/** The choices of the state's values that both a control and a key set: label of each value, in order. */

export const LAYOUTS = { beside: 'Beside', over: 'Over' };
export const VIEWS = { free: 'Free', front: 'Front', side: 'Side', top: 'Top' };
export const BODIES = { mannequin: 'Mannequin', stick: 'Stick', own: 'Own' };
export const CROWDS = [0, 1, 10, 100, 1000]; // characters
