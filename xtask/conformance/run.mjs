// Prints the reports of all scenes: node run.mjs conformance.wasm
import { readFileSync } from "node:fs";

const module = new WebAssembly.Module(readFileSync(process.argv[2]));
// No imports are given, so a module that asks for a clock, a file or a thread does not start.
const { exports } = new WebAssembly.Instance(module);
const text = () =>
  new TextDecoder().decode(new Uint8Array(exports.memory.buffer, exports.text(), exports.text_length()));

for (let scene = 0; scene < exports.scene_count(); scene++) {
  try {
    exports.report(scene);
  } catch (trap) {
    console.error(`${trap}: ${text()}`);
    process.exit(1);
  }
  console.log(text());
}
