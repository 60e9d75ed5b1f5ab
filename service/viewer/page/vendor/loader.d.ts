export * from '../../vendor/loader.js';
