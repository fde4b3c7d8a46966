// Prints what a page downloads, part by part, and fails if the core module is larger than promised.
import { readFileSync, readdirSync } from 'node:fs';
import { brotliCompressSync, constants, gzipSync } from 'node:zlib';

const root = new URL('../', import.meta.url);
const brotli = { params: { [constants.BROTLI_PARAM_QUALITY]: 11, [constants.BROTLI_PARAM_LGWIN]: 24 } };
const kilobytes = (bytes) => `${(bytes / 1024).toFixed(0)} KiB`.padStart(9);
const files = ['wasm', 'dist'].flatMap((folder) =>
  readdirSync(new URL(folder, root), { recursive: true }).map((file) => `${folder}/${file}`),
);

console.log(`${'file'.padEnd(28)}${'raw'.padStart(9)}${'gzip'.padStart(9)}${'brotli'.padStart(9)}`);
for (const file of files.filter((name) => /\.(wasm|js)$/.test(name))) {
  const bytes = readFileSync(new URL(file, root));
  const packed = brotliCompressSync(bytes, brotli).length;
  console.log(file.padEnd(28) + [bytes.length, gzipSync(bytes, { level: 9 }).length, packed].map(kilobytes).join(''));
  if (file.startsWith('wasm/core') && packed > 350 * 1024) {
    throw new Error(`${file} is larger than 350 KiB`);
  }
}
