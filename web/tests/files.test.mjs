// Files in Node.js: the same visible sets as the program, by hash. Needs ENFILADE_SCENES and ENFILADE_PROGRAM.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { loadFiles, SceneFile } from '../dist/files.js';

const { ENFILADE_SCENES: scenes, ENFILADE_PROGRAM: program } = process.env;
const paths = JSON.parse(readFileSync(new URL('paths.json', import.meta.url)));
const palace = new URL('../../crates/enfilade_scenes/src/palace.glb', import.meta.url);

await loadFiles({ wasm: readFileSync(new URL('../wasm/files_bg.wasm', import.meta.url)) });

test('a broken file is an error that says what is wrong with it', () => {
  assert.throws(() => new SceneFile(new Uint8Array([1, 2, 3])), { code: 'file/unreadable' });
  const bytes = readFileSync(palace);
  assert.throws(() => new SceneFile(bytes.subarray(0, 5000)), { code: 'file/unreadable' });
  assert.throws(() => new SceneFile(bytes, { limitBytes: 1e6 }), { code: 'file/unreadable' });
});

test('the palace has its rooms, and its cameras see through doors and mirrors', () => {
  const file = new SceneFile(readFileSync(palace));
  assert.ok(file.sectors.length >= 33 && file.cameras.length > 3, `${file.sectors.length}, ${file.cameras.length}`);
  const viewer = file.createViewer();
  for (const camera of file.cameras) {
    viewer.lookFrom(camera, { width: 320, height: 180 });
    const seen = [...viewer.visible].map((key) => file.items[key]);
    assert.ok(seen.length > 5 && seen.length < file.items.length / 2, `${seen.length} of ${file.items.length}`);
  }
  viewer.lookFrom(file.cameras[0], { width: 320, height: 180 });
  assert.ok(viewer.isComplete);
  // Where mirrors face each other, there is no end.
  viewer.lookFrom({ eye: [0, 1.72, -67.5], toward: [1, 1.72, -67.5], up: [0, 1, 0], fovY: Math.PI / 4 }, { width: 1280, height: 720 });
  assert.ok(!viewer.isComplete && viewer.visible.length === file.items.length);
  const { positions, indices, groups } = file.mesh(0);
  assert.ok(groups.reduce((sum, { count }) => sum + count, 0) === indices.length && Math.max(...indices) < positions.length / 3);
});

const hash = (names) => createHash('sha256').update([...names].sort().join('\n')).digest('hex').slice(0, 16);

for (const [name, stops] of Object.entries(paths)) {
  test(`${name}: the visible sets of the program`, { skip: !(scenes && program), timeout: 300_000 }, () => {
    const folder = mkdtempSync(join(tmpdir(), 'enfilade-web-'));
    const [path, report] = [join(folder, 'path.jsonl'), join(folder, 'report.json')];
    const glb = join(scenes, `${name}.glb`);
    writeFileSync(path, stops.map(([a, b, c, ...toward]) => JSON.stringify({ eye: [a, b, c], toward, up: [0, 1, 0], fov: 60 })).join('\n'));
    execFileSync(program, ['look', glb, '--method', 'masked', '--flat', '--path', path, '--size', '640x360', '--json', report]);
    const native = JSON.parse(readFileSync(report)).views.map(({ visible }) => hash(visible));
    rmSync(folder, { recursive: true });
    const file = new SceneFile(readFileSync(glb), { flat: true });
    const viewer = file.createViewer({ growthPx: 0 });
    const here = stops.map(([a, b, c, ...toward]) => {
      viewer.lookFrom({ eye: [a, b, c], toward, up: [0, 1, 0], fovY: Math.PI / 3 }, { width: 640, height: 360 });
      return hash([...viewer.visible].map((key) => file.items[key].name));
    });
    assert.deepEqual(here, native);
    assert.ok(new Set(here).size > stops.length / 2);
  });
}
