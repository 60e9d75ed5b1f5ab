import { Catalogue } from './catalogue.js';
import { Player } from './player.js';
import { Service } from './service.js';
import { Sides } from './sides.js';
import { State } from './state.js';

const service = new Service();
const state = new State(new URLSearchParams(location.search));
const player = new Player(state);
const catalogue = await Catalogue.load(service);
const sides = new Sides(service, catalogue);
console.log(state, player, sides);
