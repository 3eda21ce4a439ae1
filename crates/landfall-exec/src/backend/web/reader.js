// Runs the jobs of Landfall's backends `webgl` and `webgpu` in a page; shader text comes as data.
//
// The value of this script is an object with a function for each request. Each returns one of the
// replies of `wire.rs`: `Opened`, `Ran`, `Reflected` or `Failed`.
(() => {
  "use strict";

  /** A reply in place of a result. */
  class Refusal extends Error {
    constructor(kind, message, log) {
      super(message);
      this.reply = { Failed: { kind, message, log: log ?? "" } };
    }
  }

  const refused = (message, log) => new Refusal("Refused", message, log);
  const died = (message, log) => new Refusal("Died", message, log);
  const missing = (message, log) => new Refusal("Missing", message, log);

  const reply = async (work) => {
    try {
      return await work();
    } catch (error) {
      return error instanceof Refusal ? error.reply : died("the page failed", String(error)).reply;
    }
  };

  const software = (name) => /swiftshader|llvmpipe|lavapipe|basic render/i.test(name);

  // WebGL 2

  let open = null;

  const context = () => {
    if (open?.isContextLost()) throw died("the browser lost the WebGL context");
    if (open) return open;
    const gl = document.createElement("canvas").getContext("webgl2", { antialias: false });
    if (!gl) throw missing("this browser has no WebGL 2 here");
    // Floats as colours.
    gl.getExtension("EXT_color_buffer_float");
    open = gl;
    return gl;
  };

  const openGl = () => {
    const gl = context();
    const about = gl.getExtension("WEBGL_debug_renderer_info");
    const adapter = String(gl.getParameter(about ? about.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    return {
      Opened: {
        adapter,
        software: software(adapter),
        limits: {
          uniform_block_size: gl.getParameter(gl.MAX_UNIFORM_BLOCK_SIZE),
          uniform_blocks: gl.getParameter(gl.MAX_FRAGMENT_UNIFORM_BLOCKS),
          image_side: Math.min(
            gl.getParameter(gl.MAX_TEXTURE_SIZE),
            ...gl.getParameter(gl.MAX_VIEWPORT_DIMS),
          ),
        },
      },
    };
  };

  /** The last program, since the passes of a probe share it. */
  let last = { key: null, program: null };

  const compiled = (gl, stage, text) => {
    const shader = gl.createShader(stage === "vertex" ? gl.VERTEX_SHADER : gl.FRAGMENT_SHADER);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
      const log = gl.getShaderInfoLog(shader);
      gl.deleteShader(shader);
      context();
      throw refused(`the browser rejects the ${stage} shader`, log);
    }
    return shader;
  };

  const linked = (gl, stages) => {
    const key = JSON.stringify(stages);
    if (last.key === key) return last.program;
    if (last.program) gl.deleteProgram(last.program);
    last = { key: null, program: null };
    const program = gl.createProgram();
    for (const { stage, text } of stages) {
      const shader = compiled(gl, stage, text);
      gl.attachShader(program, shader);
      // Lives as long as the program.
      gl.deleteShader(shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      const log = gl.getProgramInfoLog(program);
      gl.deleteProgram(program);
      context();
      throw refused("the browser does not link the shaders", log);
    }
    last = { key, program };
    return program;
  };

  /** Binds a buffer to every active block: zeros, where the job has none. */
  const bindBlocks = (gl, program, resources, made) => {
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORM_BLOCKS);
    for (let block = 0; block < count; block += 1) {
      const name = gl.getActiveUniformBlockName(program, block);
      const words = resources.find((one) => one.kind === "uniform" && one.name === name)?.words;
      const size = gl.getActiveUniformBlockParameter(program, block, gl.UNIFORM_BLOCK_DATA_SIZE);
      const filled = new Uint32Array(Math.max(Math.ceil(size / 4), words?.length ?? 0));
      filled.set(words ?? []);
      const buffer = gl.createBuffer();
      made.push(() => gl.deleteBuffer(buffer));
      gl.bindBufferBase(gl.UNIFORM_BUFFER, block, buffer);
      gl.bufferData(gl.UNIFORM_BUFFER, filled, gl.STATIC_DRAW);
      gl.uniformBlockBinding(program, block, block);
    }
  };

  const setLoose = (gl, program, resources) => {
    for (const { uniforms } of resources.filter((one) => one.kind === "loose")) {
      for (const { name, words } of uniforms) {
        const place = gl.getUniformLocation(program, name);
        if (place && words.length === 4) gl.uniform4uiv(place, words);
        else if (place) throw refused(`the uniform \`${name}\` is no uvec4`);
      }
    }
  };

  const runGl = (job) => {
    const gl = context();
    const [kind, grid] = Object.entries(job.grid)[0];
    if (kind === "Groups") throw refused("WebGL 2 has no compute shaders");
    const width = kind === "Image" ? grid.width : grid.count;
    const height = kind === "Image" ? grid.height : 1;
    const made = [];
    try {
      const program = linked(gl, job.stages);
      gl.useProgram(program);
      bindBlocks(gl, program, job.resources, made);
      setLoose(gl, program, job.resources);
      const texture = gl.createTexture();
      const frame = gl.createFramebuffer();
      made.push(() => gl.deleteTexture(texture), () => gl.deleteFramebuffer(frame));
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, grid.texel === "Uint" ? gl.RGBA32UI : gl.RGBA32F, width, height);
      gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
      gl.viewport(0, 0, width, height);
      if (kind === "Image") gl.drawArrays(gl.TRIANGLES, 0, 3);
      else gl.drawArrays(gl.POINTS, 0, width);
      const pixels = new Uint32Array(width * height * 4);
      if (grid.texel === "Uint") {
        gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, pixels);
      } else {
        gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, new Float32Array(pixels.buffer));
      }
      const error = gl.getError();
      context();
      if (error !== gl.NO_ERROR) {
        throw refused(`WebGL reports the error 0x${error.toString(16)}`);
      }
      return { Ran: { buffers: job.resources.map(() => null), pixels: Array.from(pixels) } };
    } finally {
      made.forEach((remove) => remove());
    }
  };

  const TYPES = {
    FLOAT: "float", FLOAT_VEC2: "vec2", FLOAT_VEC3: "vec3", FLOAT_VEC4: "vec4",
    INT: "int", INT_VEC2: "ivec2", INT_VEC3: "ivec3", INT_VEC4: "ivec4",
    UNSIGNED_INT: "uint", UNSIGNED_INT_VEC2: "uvec2", UNSIGNED_INT_VEC3: "uvec3",
    UNSIGNED_INT_VEC4: "uvec4",
    BOOL: "bool", BOOL_VEC2: "bvec2", BOOL_VEC3: "bvec3", BOOL_VEC4: "bvec4",
    FLOAT_MAT2: "mat2", FLOAT_MAT3: "mat3", FLOAT_MAT4: "mat4",
    FLOAT_MAT2x3: "mat2x3", FLOAT_MAT2x4: "mat2x4", FLOAT_MAT3x2: "mat3x2",
    FLOAT_MAT3x4: "mat3x4", FLOAT_MAT4x2: "mat4x2", FLOAT_MAT4x3: "mat4x3",
  };

  /** The path of a member without its block: `B[1].lights[0].pos` is `lights[0].pos`. */
  const withoutBlock = (member, block) => {
    const name = block.split("[")[0];
    if (!member.startsWith(name)) return member;
    const rest = member.slice(name.length).replace(/^(\[\d+\])+(?=\.)/, "");
    return rest.startsWith(".") ? rest.slice(1) : member;
  };

  /** Offsets and strides by getUniformIndices and getActiveUniforms (WebGL 2 §3.7.16). */
  const reflectGl = ({ stages }) => {
    const gl = context();
    const program = linked(gl, stages);
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    const listed = Array.from({ length: count }, (_, at) => gl.getActiveUniform(program, at));
    const indices = gl.getUniformIndices(program, listed.map((uniform) => uniform.name));
    const facts = (name) => gl.getActiveUniforms(program, indices, name);
    const type = (uniform) => {
      const known = Object.entries(TYPES).find(([name]) => gl[name] === uniform.type);
      return known ? known[1] : `0x${uniform.type.toString(16)}`;
    };
    const block = facts(gl.UNIFORM_BLOCK_INDEX);
    const offset = facts(gl.UNIFORM_OFFSET);
    const arrayStride = facts(gl.UNIFORM_ARRAY_STRIDE);
    const matrixStride = facts(gl.UNIFORM_MATRIX_STRIDE);
    const rowMajor = facts(gl.UNIFORM_IS_ROW_MAJOR);
    const blocks = gl.getProgramParameter(program, gl.ACTIVE_UNIFORM_BLOCKS);
    const uniform_blocks = Array.from({ length: blocks }, (_, at) => ({
      name: gl.getActiveUniformBlockName(program, at),
      binding: gl.getActiveUniformBlockParameter(program, at, gl.UNIFORM_BLOCK_BINDING),
      size: gl.getActiveUniformBlockParameter(program, at, gl.UNIFORM_BLOCK_DATA_SIZE),
      members: [],
    }));
    const uniforms = [];
    listed.forEach((uniform, at) => {
      const ty = type(uniform);
      const own = uniform_blocks[block[at]];
      if (!own) {
        uniforms.push({ name: uniform.name, ty, array_size: uniform.size });
        return;
      }
      own.members.push({
        name: withoutBlock(uniform.name, own.name),
        ty,
        offset: offset[at],
        array_size: uniform.size,
        array_stride: arrayStride[at],
        matrix_stride: matrixStride[at],
        row_major: Boolean(rowMajor[at]),
        top_level: null,
      });
    });
    context();
    return { Reflected: { uniform_blocks, storage_blocks: [], uniforms } };
  };

  // WebGPU

  let gpu = null;

  const device = async () => {
    if (gpu?.lost) throw died("the browser lost the WebGPU device", gpu.lost);
    if (gpu) return gpu;
    if (!navigator.gpu) throw missing("this browser has no WebGPU here");
    const adapter =
      (await navigator.gpu.requestAdapter()) ??
      (await navigator.gpu.requestAdapter({ forceFallbackAdapter: true }));
    if (!adapter) throw missing("this browser has WebGPU, but no adapter for it");
    const limits = [
      "maxBufferSize", "maxStorageBufferBindingSize", "maxUniformBufferBindingSize",
      "maxTextureDimension2D",
    ];
    const opened = await adapter.requestDevice({
      requiredFeatures: ["shader-f16", "subgroups"].filter((name) => adapter.features.has(name)),
      requiredLimits: Object.fromEntries(limits.map((name) => [name, adapter.limits[name]])),
    });
    gpu = { adapter, device: opened, lost: null };
    opened.lost.then((info) => {
      gpu.lost = info.message || info.reason;
    });
    return gpu;
  };

  const openGpu = async () => {
    const { adapter, device: { limits } } = await device();
    const { vendor, architecture, device: model, description, isFallbackAdapter } = adapter.info;
    const named = [vendor, architecture, model].filter((part) => part).join(" ");
    return {
      Opened: {
        adapter: description || named || "unnamed adapter",
        software: isFallbackAdapter || software(`${named} ${description}`),
        limits: {
          uniform_block_size: limits.maxUniformBufferBindingSize,
          storage_block_size: limits.maxStorageBufferBindingSize,
          uniform_blocks: limits.maxUniformBuffersPerShaderStage,
          storage_blocks: limits.maxStorageBuffersPerShaderStage,
          image_side: limits.maxTextureDimension2D,
          workgroup_invocations: limits.maxComputeInvocationsPerWorkgroup,
          workgroups: limits.maxComputeWorkgroupsPerDimension,
        },
      },
    };
  };

  const compiledGpu = async (device, text) => {
    const module = device.createShaderModule({ code: text });
    const { messages } = await module.getCompilationInfo();
    const errors = messages.filter((message) => message.type === "error");
    if (errors.length > 0) {
      const log = errors.map((one) => `${one.lineNum}:${one.linePos} error: ${one.message}`);
      throw refused("the browser rejects the shader", log.join("\n"));
    }
    return module;
  };

  /** Runs work, and fails with what the device reports of it. */
  const checked = async (device, work) => {
    const kinds = ["validation", "out-of-memory", "internal"];
    kinds.forEach((kind) => device.pushErrorScope(kind));
    let result;
    let thrown = null;
    try {
      result = await work();
    } catch (error) {
      thrown = error;
    }
    const reported = [];
    for (const _ of kinds) reported.push(await device.popErrorScope());
    const first = reported.find((error) => error);
    if (thrown instanceof Refusal) throw thrown;
    if (first) throw refused("the browser rejects the pipeline", first.message);
    if (thrown) throw refused("the browser rejects the pipeline", thrown.message);
    return result;
  };

  const TRIANGLE = `@vertex fn covering(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(select(-1.0, 3.0, at == 1u), select(-1.0, 3.0, at == 2u), 0.0, 1.0);
}`;

  const TYPES_OF_BUFFERS = {
    uniform: "uniform", storage: "read-only-storage", writable: "storage",
  };

  const bindGroups = (device, resources, visibility, made) => {
    const buffers = resources.map(({ kind, words }) => {
      if (!(kind in TYPES_OF_BUFFERS)) return null;
      const usage = kind === "uniform" ? GPUBufferUsage.UNIFORM : GPUBufferUsage.STORAGE;
      const buffer = device.createBuffer({
        size: Math.max(words.length * 4, 16),
        usage: usage | GPUBufferUsage.COPY_SRC | GPUBufferUsage.COPY_DST,
      });
      made.push(buffer);
      device.queue.writeBuffer(buffer, 0, new Uint32Array(words));
      return buffer;
    });
    const most = Math.max(...resources.map(({ group }) => group));
    const groups = Array.from({ length: most + 1 }, (_, group) => {
      const own = resources
        .map((resource, at) => ({ ...resource, buffer: buffers[at] }))
        .filter((resource) => resource.group === group && resource.buffer);
      const layout = device.createBindGroupLayout({
        entries: own.map(({ binding, kind }) => ({
          binding, visibility, buffer: { type: TYPES_OF_BUFFERS[kind] },
        })),
      });
      const entries = own.map(({ binding, buffer }) => ({ binding, resource: { buffer } }));
      return { layout, bound: device.createBindGroup({ layout, entries }) };
    });
    return { buffers, groups };
  };

  const encode = async (device, job, groups, encoder, made) => {
    const [kind, grid] = Object.entries(job.grid)[0];
    const [{ text, entry: entryPoint }] = job.stages;
    const module = await compiledGpu(device, text);
    const layout = device.createPipelineLayout({
      bindGroupLayouts: groups.map((group) => group.layout),
    });
    const bind = (pass) => groups.forEach((group, at) => pass.setBindGroup(at, group.bound));
    if (kind === "Groups") {
      const compute = { module, entryPoint };
      const pipeline = await device.createComputePipelineAsync({ layout, compute });
      const pass = encoder.beginComputePass();
      pass.setPipeline(pipeline);
      bind(pass);
      pass.dispatchWorkgroups(...grid);
      pass.end();
      return;
    }
    if (kind !== "Image") throw refused("WebGPU jobs draw images or run workgroups");
    const format = grid.texel === "Uint" ? "rgba32uint" : "rgba32float";
    const pipeline = await device.createRenderPipelineAsync({
      layout,
      vertex: { module: device.createShaderModule({ code: TRIANGLE }) },
      fragment: { module, entryPoint, targets: [{ format }] },
    });
    const texture = device.createTexture({
      size: [grid.width, grid.height], format, usage: GPUTextureUsage.RENDER_ATTACHMENT,
    });
    made.push(texture);
    const view = texture.createView();
    const pass = encoder.beginRenderPass({
      colorAttachments: [{ view, loadOp: "clear", storeOp: "store" }],
    });
    pass.setPipeline(pipeline);
    bind(pass);
    pass.draw(3);
    pass.end();
  };

  const runGpu = async (job) => {
    const { device: own } = await device();
    const made = [];
    try {
      const copies = await checked(own, async () => {
        const stage = "Groups" in job.grid ? GPUShaderStage.COMPUTE : GPUShaderStage.FRAGMENT;
        const { buffers, groups } = bindGroups(own, job.resources, stage, made);
        const encoder = own.createCommandEncoder();
        await encode(own, job, groups, encoder, made);
        const copies = job.resources.map(({ kind }, at) => {
          if (kind !== "writable") return null;
          const { size } = buffers[at];
          const usage = GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST;
          const copy = own.createBuffer({ size, usage });
          made.push(copy);
          encoder.copyBufferToBuffer(buffers[at], 0, copy, 0, size);
          return copy;
        });
        own.queue.submit([encoder.finish()]);
        return copies;
      });
      const results = [];
      for (const [at, copy] of copies.entries()) {
        if (!copy) {
          results.push(null);
          continue;
        }
        await copy.mapAsync(GPUMapMode.READ);
        const words = new Uint32Array(copy.getMappedRange());
        results.push(Array.from(words.subarray(0, job.resources[at].words.length)));
      }
      return { Ran: { buffers: results, pixels: [] } };
    } finally {
      made.forEach((thing) => thing.destroy());
      if (gpu?.lost) throw died("the browser lost the WebGPU device", gpu.lost);
    }
  };

  /** WebGPU reports no offsets; this tells whether it takes the text. */
  const reflectGpu = async ({ stages }) => {
    const { device: own } = await device();
    for (const { text } of stages) await checked(own, () => compiledGpu(own, text));
    return { Reflected: { uniform_blocks: [], storage_blocks: [], uniforms: [] } };
  };

  return {
    open: (api) => reply(api === "webgl" ? openGl : openGpu),
    run: (api, job) => reply(() => (api === "webgl" ? runGl(job) : runGpu(job))),
    reflect: (api, texts) => reply(() => (api === "webgl" ? reflectGl(texts) : reflectGpu(texts))),
  };
})()
