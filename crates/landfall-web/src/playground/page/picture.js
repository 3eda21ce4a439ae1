// A scene drawn by WebGL 2 with the shader in GLSL ES 3.00: one pass for each material writes floats,
// the next one makes 8 bits of them, linear or sRGB. Fragments come from the engine, so that every pixel gets the very
// inputs that `landfall render` gives it: they lie in a texture, by pixel, one input below the other.

const WHOLE = `#version 300 es
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0); }`;

const SHOWN = `#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2D lit;
uniform highp sampler2D which;
uniform float material;
uniform vec3 background;
uniform bool srgb;
out vec4 color;
float coded(float x) {
    float c = clamp(x, 0.0, 1.0);
    if (!srgb) return c;
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1.0 / 2.4) - 0.055;
}
void main() {
    ivec2 at = ivec2(int(gl_FragCoord.x), textureSize(which, 0).y - 1 - int(gl_FragCoord.y));
    if (texelFetch(which, at, 0).r != material) discard;
    vec3 c = material == 0.0 ? background : texelFetch(lit, at, 0).rgb;
    bool odd = any(isnan(c)) || any(isinf(c));
    color = odd ? vec4(1.0, 0.0, 1.0, 1.0) : vec4(coded(c.r), coded(c.g), coded(c.b), 1.0);
}`;

/** Where scalars, vectors, matrices and arrays of them start, in every structure of an array. */
function leafStarts(members, base, found) {
  for (const member of members) {
    const starts = member.leaf ? [0] : (member.dims ?? []).reduce((all, count, dim) => (
      all.flatMap((at) => Array.from({ length: count ?? 1 }, (_, index) => at + index * member.strides[dim]))
    ), [0]);
    for (const start of starts) {
      if (member.leaf) found.add(base + member.offset + start);
      else leafStarts(member.members, base + member.offset + start, found);
    }
  }
  return found;
}

const bytesOf = (base64) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
const floatsOf = (base64) => new Float32Array(bytesOf(base64).buffer);
const wordsOf = (base64) => new Uint32Array(bytesOf(base64).buffer);

class GlPicture {
  constructor() {
    const canvas = document.createElement('canvas');
    Object.assign(this, { canvas, api: 'WebGL 2' });
    const gl = canvas.getContext('webgl2', { alpha: false, antialias: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error('this browser has no WebGL 2');
    if (!gl.getExtension('EXT_color_buffer_float')) throw new Error('WebGL 2 has no float targets here (EXT_color_buffer_float)');
    Object.assign(this, { gl, textures: new Map() });
    this.shown = this.program(SHOWN);
    gl.bindVertexArray(gl.createVertexArray());
  }

  program(fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, WHOLE], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
        throw new Error(`WebGL does not compile the shader: ${gl.getShaderInfoLog(shader)}`);
      }
      gl.attachShader(program, shader);
      gl.deleteShader(shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(`WebGL does not link the shader: ${gl.getProgramInfoLog(program)}`);
    return program;
  }

  /** A texture of floats by a name; `null` makes one to draw to. */
  texture(name, width, height, texels) {
    const { gl } = this;
    if (!this.textures.has(name)) this.textures.set(name, gl.createTexture());
    const texture = this.textures.get(name);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, width, height, 0, gl.RGBA, gl.FLOAT, texels);
    for (const key of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, key, gl.NEAREST);
    for (const key of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, key, gl.REPEAT);
    return texture;
  }

  setShader({ webgl: { Ok: shader, Err: refusal } }, layouts) {
    if (refusal !== undefined) throw new Error(`does not run on WebGL 2: ${refusal}`);
    const { gl } = this;
    const { text, blocks, samplers } = shader;
    const program = this.program(text);
    if (this.own) gl.deleteProgram(this.own);
    Object.assign(this, { own: program, blocks, samplers });
    blocks.forEach((name, number) => {
      if (name === null) return;
      const index = gl.getUniformBlockIndex(program, name);
      if (index !== gl.INVALID_INDEX) gl.uniformBlockBinding(program, index, number);
    });
    this.refuseOffsets(program, blocks, layouts);
    gl.useProgram(program);
    samplers.forEach(([name], number) => gl.uniform1i(gl.getUniformLocation(program, name), number));
  }

  /** Refuses a shader whose blocks WebGL lays out otherwise than Landfall, as it says itself. */
  refuseOffsets(program, blocks, layouts) {
    const { gl } = this;
    blocks.forEach((name, number) => {
      const index = name === null ? gl.INVALID_INDEX : gl.getUniformBlockIndex(program, name);
      const layout = layouts[number];
      if (index === gl.INVALID_INDEX || !layout) return;
      const starts = leafStarts(layout.members, 0, new Set());
      const active = [...gl.getActiveUniformBlockParameter(program, index, gl.UNIFORM_BLOCK_ACTIVE_UNIFORM_INDICES)];
      const wrong = gl.getActiveUniforms(program, active, gl.UNIFORM_OFFSET).find((offset) => !starts.has(offset));
      const size = gl.getActiveUniformBlockParameter(program, index, gl.UNIFORM_BLOCK_DATA_SIZE);
      if (wrong !== undefined) throw new Error(`WebGL reads a member of ${name} at byte ${wrong}, where Landfall has none: its rules are ${layout.rules}`);
      if (size > Math.ceil(layout.size / 16) * 16) throw new Error(`WebGL wants ${size} bytes for ${name}, Landfall has ${layout.size}: its rules are ${layout.rules}`);
    });
  }

  setFrame({ pixels, materials, inputs }, [width, height]) {
    const { gl, canvas } = this;
    [canvas.width, canvas.height] = [width, height];
    const [at, kinds] = [wordsOf(pixels), wordsOf(materials)];
    const atlas = new Float32Array(4 * width * height * Math.max(1, inputs.length));
    inputs.forEach(([components, values], number) => {
      const given = floatsOf(values);
      for (let one = 0; one < at.length; one += 1) {
        const to = 4 * (number * width * height + at[one]);
        for (let c = 0; c < components; c += 1) atlas[to + c] = given[one * components + c];
      }
    });
    const which = new Float32Array(4 * width * height);
    at.forEach((pixel, one) => { which[4 * pixel] = kinds[one] + 1; });
    this.texture('atlas', width, height * Math.max(1, inputs.length), atlas);
    this.texture('which', width, height, which);
    const lit = this.texture('lit', width, height, null);
    this.target ??= gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, lit, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    Object.assign(this, { used: [...new Set(kinds)].sort((a, b) => a - b), fragments: at.length, kinds: new Map([...at].map((pixel, one) => [pixel, kinds[one]])) });
  }

  /** The bytes of the blocks and the textures of each material. */
  setMaterials(materials) {
    const { gl } = this;
    this.buffers ??= [];
    materials.forEach(({ blocks, textures }, material) => {
      this.buffers[material] ??= [];
      blocks.forEach((bytes, number) => {
        this.buffers[material][number] ??= gl.createBuffer();
        gl.bindBuffer(gl.UNIFORM_BUFFER, this.buffers[material][number]);
        // WebGL wants whole vectors at the end.
        const padded = new Uint8Array(Math.ceil(Math.max(bytes.length, 16) / 16) * 16);
        padded.set(bytes);
        gl.bufferData(gl.UNIFORM_BUFFER, padded, gl.DYNAMIC_DRAW);
      });
      textures.forEach(({ width, height, texels }, number) => {
        const name = `${material} ${number}`;
        if (this.textures.get(`${name} texels`) === texels) return;
        this.textures.set(`${name} texels`, texels);
        this.texture(name, width, height, floatsOf(texels));
      });
    });
  }

  /** Draws the scene and returns its picture. */
  draw(background, srgb) {
    const { gl, canvas } = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    Object.assign(this, { background, srgb });
    this.show(0);
    for (const material of this.used) {
      this.light(material);
      this.show(material + 1);
    }
    const error = gl.getError();
    if (error !== gl.NO_ERROR) throw new Error(`WebGL fails to draw the scene (error ${error})`);
    return canvas;
  }

  /** Lights all pixels as if they were of a material. */
  light(material) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.clearColor(...this.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.useProgram(this.own);
    this.buffers[material].forEach((buffer, number) => gl.bindBufferBase(gl.UNIFORM_BUFFER, number, buffer));
    this.samplers.forEach(([, texture], number) => {
      gl.activeTexture(gl.TEXTURE0 + number);
      gl.bindTexture(gl.TEXTURE_2D, this.textures.get(texture === null ? 'atlas' : `${material} ${texture}`));
    });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** Codes the pixels of a material, from 1; 0 is what is behind. */
  show(material) {
    const { gl, shown, background, srgb } = this;
    gl.useProgram(shown);
    ['lit', 'which'].forEach((name, number) => {
      gl.activeTexture(gl.TEXTURE0 + number);
      gl.bindTexture(gl.TEXTURE_2D, this.textures.get(name));
      gl.uniform1i(gl.getUniformLocation(shown, name), number);
    });
    gl.uniform1f(gl.getUniformLocation(shown, 'material'), material);
    gl.uniform3fv(gl.getUniformLocation(shown, 'background'), background);
    gl.uniform1i(gl.getUniformLocation(shown, 'srgb'), srgb ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The light of a pixel; `null` where nothing is drawn. */
  read(column, row) {
    const { gl, canvas: { width } } = this;
    const material = this.kinds.get(row * width + column);
    if (material === undefined) return null;
    this.light(material);
    const found = new Float32Array(4);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.readPixels(column, row, 1, 1, gl.RGBA, gl.FLOAT, found);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return [...found.slice(0, 3)];
  }
}
