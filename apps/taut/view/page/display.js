// Linear half floats on the screen: exposure, view transform, false colours and the wipe are a fragment shader's work.

const kVertex = `#version 300 es
out vec2 at;
void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  at = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}`;

const kFragment = `#version 300 es
precision highp float;
in vec2 at;
out vec4 color;
uniform sampler2D leftImage, rightImage, leftValue, rightValue;
uniform mediump sampler3D view; // the scene's own: apps/taut/view/picture.h
uniform float wipe, exposure;
uniform int transform;
uniform vec2 range;
uniform bool falseColours;

// Dark blue over grey to yellow: lightness grows throughout, and the hues stay apart for every kind of sight.
vec3 ramp(float u) {
  u = clamp(u, 0.0, 1.0);
  vec3 low = vec3(0.0, 0.135, 0.304), middle = vec3(0.486, 0.482, 0.471), high = vec3(0.996, 0.91, 0.217);
  return u < 0.5 ? mix(low, middle, 2.0 * u) : mix(middle, high, 2.0 * u - 1.0);
}
vec3 encoded(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
// Narkowicz 2015, a fit to the ACES reference transform.
vec3 filmic(vec3 c) {
  return clamp(c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14), 0.0, 1.0);
}
vec3 viewed(vec3 c) {
  float steps = float(textureSize(view, 0).x);
  vec3 u = (log2(clamp(c, 0.0, 511.0) + exp2(-10.0)) + 10.0) / 19.0;
  return texture(view, (u * (steps - 1.0) + 0.5) / steps).rgb;
}
void main() {
  bool left = at.x < wipe;
  vec4 seen = left ? texture(leftImage, at) : texture(rightImage, at);
  vec3 c = seen.rgb * exp2(exposure);
  if (falseColours) {
    float value = left ? texture(leftValue, at).r : texture(rightValue, at).r;
    color = vec4(seen.a > 0.0 ? ramp((value - range.x) / max(range.y - range.x, 1e-6)) : vec3(0.0), 1.0);
  } else if (transform == 2) {
    float stops = log2(max(dot(c, vec3(0.2126, 0.7152, 0.0722)), 1e-6) / 0.18);
    color = vec4(ramp((stops + 6.0) / 12.0), 1.0);
  } else if (transform == 3) {
    color = vec4(viewed(c), 1.0);
  } else {
    color = vec4(encoded(transform == 1 ? filmic(c) : c), 1.0);
  }
}`;

function program(gl) {
  const made = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, kVertex], [gl.FRAGMENT_SHADER, kFragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  return made;
}

export class Display {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext('webgl2', { antialias: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error('This browser has no WebGL 2, which shows the picture.');
    this.look = { wipe: 1, exposure: 0, transform: 0, range: [0, 1], falseColours: false };
    this.sources = {};
    this.prepare();
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => {
      this.prepare();
      this.show(this.sources.left, this.sources.right);
    });
  }

  prepare() {
    const gl = this.gl;
    this.program = program(gl);
    this.uniforms = Object.fromEntries(
      ['leftImage', 'rightImage', 'leftValue', 'rightValue', 'wipe', 'exposure', 'transform', 'range', 'falseColours', 'view']
        .map((name) => [name, gl.getUniformLocation(this.program, name)]));
    this.textures = [0, 1, 2, 3].map((unit) => {
      const texture = gl.createTexture();
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST],
        [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, key, value);
      return texture;
    });
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
    this.loaded = [null, null];
    gl.activeTexture(gl.TEXTURE4);
    gl.bindTexture(gl.TEXTURE_3D, gl.createTexture());
    for (const [key, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_R, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_3D, key, value);
    this.takeView(this.view ?? new Uint16Array(4));
  }

  // The scene's view transform, as the server tells it; `transform` 3 shows through it.
  takeView(table) {
    const gl = this.gl;
    this.view = table;
    const steps = Math.round(Math.cbrt(table.length / 4));
    gl.activeTexture(gl.TEXTURE4);
    gl.texImage3D(gl.TEXTURE_3D, 0, gl.RGBA16F, steps, steps, steps, 0, gl.RGBA, gl.HALF_FLOAT, table);
  }

  // Pictures on both sides of the wipe; `part` is the channel of false colours, or with `isColour` the first of three that are shown.
  show(left, right, part = this.part ?? 0, isColour = this.isColour ?? false) {
    this.sources = { left, right };
    const again = part !== this.part || isColour !== this.isColour;
    Object.assign(this, { part, isColour });
    if (!left) return;
    if (this.canvas.width !== left.width || this.canvas.height !== left.height) {
      this.canvas.width = left.width;
      this.canvas.height = left.height;
    }
    for (const [side, picture] of [left, right ?? left].entries()) {
      if (this.loaded[side] === picture && !again) continue;
      this.load(side, picture, part);
      this.loaded[side] = picture;
    }
    this.draw();
  }

  load(side, picture, part) {
    const gl = this.gl;
    const pixels = picture.columns * picture.rows;
    let image = picture.values;
    let value = new Uint16Array(1);
    if (picture.channels > 4) {
      image = new Uint16Array(4 * pixels);
      value = new Uint16Array(pixels);
      for (let i = 0; i < pixels; ++i) {
        const at = picture.channels * i;
        const colour = this.isColour && picture.channels >= 7 ? at + 4 + Math.min(part, picture.channels - 7) : at;
        for (let c = 0; c < 3; ++c) image[4 * i + c] = picture.values[colour + c];
        image[4 * i + 3] = picture.values[at + 3];
        value[i] = picture.values[at + 4 + Math.min(part, picture.channels - 5)];
      }
    }
    gl.activeTexture(gl.TEXTURE0 + side);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, picture.columns, picture.rows, 0, gl.RGBA, gl.HALF_FLOAT, image);
    gl.activeTexture(gl.TEXTURE2 + side);
    const [columns, rows] = value.length > 1 ? [picture.columns, picture.rows] : [1, 1];
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R16F, columns, rows, 0, gl.RED, gl.HALF_FLOAT, value);
  }

  draw() {
    const gl = this.gl;
    const u = this.uniforms;
    const look = this.look;
    if (!this.sources.left) return;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.useProgram(this.program);
    ['leftImage', 'rightImage', 'leftValue', 'rightValue'].forEach((name, unit) => gl.uniform1i(u[name], unit));
    gl.uniform1i(u.view, 4);
    gl.uniform1f(u.wipe, look.wipe);
    gl.uniform1f(u.exposure, look.exposure);
    gl.uniform1i(u.transform, look.transform);
    gl.uniform2f(u.range, ...look.range);
    gl.uniform1i(u.falseColours, look.falseColours ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
