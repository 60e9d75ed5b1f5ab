// Bundles what others wrote, and the client, into page/vendor: `make viewer`. The page's own modules are served as they are.
import { build } from 'esbuild';
import { copyFileSync } from 'node:fs';

const folder = process.argv[2] ?? 'page/vendor';
await build({
  entryPoints: ['vendor/three.js', 'vendor/loader.js', 'vendor/motionsplice.js'],
  outdir: folder,
  bundle: true,
  splitting: true,
  chunkNames: 'shared', // what three.js and the loader have in common
  minify: true,
  format: 'esm',
  target: 'es2022',
  legalComments: 'none',
});
copyFileSync('node_modules/three/LICENSE', `${folder}/three.LICENSE`);
