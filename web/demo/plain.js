// A file with rooms and portals in plain WebGL: only what the camera sees through doors is drawn.
import { loadFiles, SceneFile } from 'enfilade/files';

const canvas = document.querySelector('canvas');
const gl = canvas.getContext('webgl2');

await loadFiles({ wasm: 'files_bg.wasm' });
const address = new URLSearchParams(location.search).get('file') ?? 'palace.glb';
const file = new SceneFile(new Uint8Array(await (await fetch(address)).arrayBuffer()));
const viewer = file.createViewer();

// A shader that shades by the direction of each triangle.
const shader = (kind, text) => {
  const compiled = gl.createShader(kind);
  gl.shaderSource(compiled, `#version 300 es\nprecision highp float;${text}`);
  gl.compileShader(compiled);
  return compiled;
};
const program = gl.createProgram();
gl.attachShader(
  program,
  shader(
    gl.VERTEX_SHADER,
    'uniform mat4 eyeFromItem, clipFromEye; in vec3 position; out vec3 inEye; void main() { vec4 eye = eyeFromItem * vec4(position, 1); inEye = eye.xyz; gl_Position = clipFromEye * eye; }',
  ),
);
gl.attachShader(
  program,
  shader(
    gl.FRAGMENT_SHADER,
    'uniform vec4 color; in vec3 inEye; out vec4 pixel; void main() { vec3 n = normalize(cross(dFdx(inEye), dFdy(inEye))); float light = 0.35 + 0.65 * abs(dot(n, normalize(vec3(0.3, 0.5, 0.8)))); pixel = vec4(sqrt(color.rgb * light) * color.a, color.a); }',
  ),
);
gl.bindAttribLocation(program, 0, 'position');
gl.linkProgram(program);
gl.useProgram(program);
const uniform = (name) => gl.getUniformLocation(program, name);
const [eyeFromItem, clipFromEye, color] = ['eyeFromItem', 'clipFromEye', 'color'].map(uniform);

const meshes = Array.from({ length: file.meshCount }, (_, number) => {
  const { positions, indices, groups } = file.mesh(number);
  const vertexArray = gl.createVertexArray();
  gl.bindVertexArray(vertexArray);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, positions, gl.STATIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  return { vertexArray, groups };
});

// The camera, by its position and two angles.
const [first] = file.cameras;
const eye = [...(first?.eye ?? [0, 1.7, 0])];
const ahead = first ? first.toward.map((value, axis) => value - first.eye[axis]) : [0, 0, -1];
let yaw = Math.atan2(-ahead[0], -ahead[2]);
let pitch = 0;
const keys = new Set();
addEventListener('keydown', ({ code }) => keys.add(code));
addEventListener('keyup', ({ code }) => keys.delete(code));
canvas.addEventListener('pointermove', ({ buttons, movementX, movementY }) => {
  if (buttons & 1) {
    yaw += 0.003 * movementX;
    pitch = Math.max(-1.5, Math.min(1.5, pitch + 0.003 * movementY));
  }
});

/** The view matrix: columns. */
function viewMatrix() {
  const [c, s, d, t] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const [right, up, back] = [[c, 0, -s], [s * t, d, c * t], [s * d, -t, c * d]];
  const dot = (axis) => -(axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2]);
  return [
    ...[0, 1, 2].flatMap((row) => [right[row], up[row], back[row], 0]),
    ...[dot(right), dot(up), dot(back), 1],
  ];
}

/** The product of two matrices of 16 numbers. */
function multiply(a, b) {
  return Float32Array.from({ length: 16 }, (_, at) => {
    const [column, row] = [at >> 2, at & 3];
    return [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + row] * b[4 * column + k], 0);
  });
}

let before = performance.now();
function frame(now) {
  const seconds = Math.min((now - before) / 1000, 0.1);
  before = now;
  const along = (plus, minus) => 4 * seconds * (Number(keys.has(plus)) - Number(keys.has(minus)));
  const [forward, right] = [along('KeyW', 'KeyS'), along('KeyD', 'KeyA')];
  eye[0] += -Math.sin(yaw) * forward + Math.cos(yaw) * right;
  eye[2] += -Math.cos(yaw) * forward - Math.sin(yaw) * right;

  const [width, height] = [innerWidth, innerHeight].map((side) => Math.round(side * devicePixelRatio));
  if (canvas.width !== width || canvas.height !== height) {
    Object.assign(canvas, { width, height });
  }
  const [near, far, scale] = [0.05, 500, 1.5];
  const projection = [(scale * height) / width, 0, 0, 0, 0, scale, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
  const view = viewMatrix();

  const start = performance.now();
  viewer.look(view, projection, { width, height });
  const ms = performance.now() - start;

  gl.viewport(0, 0, width, height);
  gl.clearColor(0.62, 0.77, 0.91, 1);
  gl.enable(gl.DEPTH_TEST);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniformMatrix4fv(clipFromEye, false, projection);
  let [calls, triangles] = [0, 0];
  for (const key of viewer.visible) {
    const { mesh, transform } = file.items[key];
    gl.uniformMatrix4fv(eyeFromItem, false, multiply(view, transform));
    gl.bindVertexArray(meshes[mesh].vertexArray);
    for (const { start: from, count, material } of meshes[mesh].groups) {
      const { color: rgb, opacity, isDoubleSided } = file.materials[material];
      gl[isDoubleSided ? 'disable' : 'enable'](gl.CULL_FACE);
      gl[opacity < 1 ? 'enable' : 'disable'](gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.uniform4f(color, ...rgb, opacity);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * from);
      calls++;
      triangles += count / 3;
    }
  }
  document.querySelector('#counts').textContent = [
    `${file.sectors.length} rooms`,
    `objects    ${viewer.visible.length} of ${file.items.length}`,
    `triangles  ${triangles.toLocaleString('en')} of ${file.triangleCount.toLocaleString('en')}`,
    `draw calls ${calls}`,
    `look       ${ms.toFixed(2)} ms`,
  ].join('\n');
  document.body.dataset.calls = String(calls);
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);
