// Bundles the demo pages into `demo/dist/`, which any server of static files can show.
import { build } from 'esbuild';
import { copyFileSync, mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
mkdirSync(here('dist'), { recursive: true });
await build({
  entryPoints: ['walk.js', 'bim.js', 'plain.js'].map(here),
  bundle: true,
  splitting: true,
  format: 'esm',
  minify: true,
  target: 'es2022',
  outdir: here('dist'),
  alias: {
    enfilade: here('../dist/index.js'),
    'enfilade/three': here('../dist/three.js'),
    'enfilade/files': here('../dist/files.js'),
  },
  logLevel: 'warning',
});
for (const page of ['index.html', 'walk.html', 'bim.html', 'plain.html', 'style.css']) {
  copyFileSync(here(page), here(`dist/${page}`));
}
for (const module of ['core_bg.wasm', 'files_bg.wasm']) {
  copyFileSync(here(`../wasm/${module}`), here(`dist/${module}`));
}
copyFileSync(here('../../crates/enfilade_scenes/src/palace.glb'), here('dist/palace.glb'));
