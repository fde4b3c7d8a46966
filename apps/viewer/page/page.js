// Starts the viewer, shows its progress, and says what went wrong if anything does.
import init, { start } from "./viewer.js";

const [note, text, bar] = ["note", "text", "bar"].map((id) => document.getElementById(id));

function fail(message) {
  note.style.display = "";
  note.className = "failed";
  note.querySelector("h1").textContent = "The viewer has stopped";
  text.textContent = message;
  bar.hidden = true;
  document.body.dataset.state = "failed";
}

function why(error) {
  const message = String(error?.message ?? error);
  if (error instanceof WebAssembly.RuntimeError || /out of memory|unreachable/i.test(message)) {
    return `${message}\nThe page may have run out of memory: a WebAssembly page has 4 GB at most. A smaller scene, or the program on your machine, may help.`;
  }
  return message;
}

// Panics of the viewer.
window.enfiladeFailed = fail;
// Its messages, for screen readers.
window.enfiladeSaid = (message) => {
  document.getElementById("said").textContent = message;
};
window.addEventListener("error", (event) => fail(why(event.error ?? event.message)));
window.addEventListener("unhandledrejection", (event) => fail(why(event.reason)));

// Downloads a file, with progress.
async function download(url, what) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${what}: the server answers ${response.status} ${response.statusText}`);
  const size = Number(response.headers.get("content-length")) || 0;
  const chunks = [];
  let length = 0;
  for (const reader = response.body.getReader(); ; ) {
    const { done, value } = await reader.read();
    if (done) break;
    chunks.push(value);
    length += value.length;
    // The length that is told may be that of the compressed file.
    if (size >= length) bar.value = length / size;
    text.textContent = `${what}: ${(length / 1e6).toFixed(1)} MB`;
  }
  const bytes = new Uint8Array(length);
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return bytes;
}

async function run() {
  const canvas = document.getElementById("viewer");
  const adapter = await navigator.gpu?.requestAdapter().catch(() => null);
  if (!adapter && !document.createElement("canvas").getContext("webgl2")) {
    throw new Error("This browser offers neither WebGPU nor WebGL2, which the viewer draws with. Update it, or enable hardware acceleration in its settings.");
  }
  const module = await download("viewer_bg.wasm", "loading the viewer");
  text.textContent = "starting";
  await init({ module_or_path: module });
  const scene = new URLSearchParams(location.search).get("scene");
  let bytes;
  if (scene && !scene.startsWith("@")) bytes = await download(scene, `loading ${scene}`);
  await start(canvas, scene ?? undefined, bytes);
  note.style.display = "none";
  document.body.dataset.state = "running";
  canvas.focus();
}

run().catch((error) => fail(why(error)));
