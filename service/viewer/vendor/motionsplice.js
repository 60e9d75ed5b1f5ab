export * from '../../../clients/js/motionsplice.js';
