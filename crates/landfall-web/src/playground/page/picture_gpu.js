// A scene drawn by WebGPU with the shader as it is, in WGSL: a point for each fragment, whose inputs are
// vertex attributes, in a target of floats; then 8 bits of them, linear or sRGB.

const SHOWN_WGSL = `
@group(0) @binding(0) var lit: texture_2d<f32>;
@group(0) @binding(1) var<uniform> srgb: u32;
@vertex
fn whole(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(select(-1.0, 3.0, at == 1u), select(-1.0, 3.0, at == 2u), 0.0, 1.0);
}
fn coded(x: f32) -> f32 {
    let c = clamp(x, 0.0, 1.0);
    if (srgb == 0u) { return c; }
    if (c <= 0.0031308) { return 12.92 * c; }
    return 1.055 * pow(c, 1.0 / 2.4) - 0.055;
}
@fragment
fn shown(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let c = textureLoad(lit, vec2<i32>(at.xy), 0).rgb;
    // WGSL may take it that no float is NaN; its bits are asked.
    let odd = (bitcast<vec3<u32>>(c) & vec3<u32>(0x7f800000u)) == vec3<u32>(0x7f800000u);
    if (any(odd)) { return vec4<f32>(1.0, 0.0, 1.0, 1.0); }
    return vec4<f32>(coded(c.r), coded(c.g), coded(c.b), 1.0);
}`;

const LIMITS = ['maxBufferSize', 'maxStorageBufferBindingSize', 'maxUniformBufferBindingSize', 'maxTextureDimension2D', 'maxVertexAttributes', 'maxVertexBufferArrayStride', 'maxInterStageShaderVariables', 'maxStorageBuffersPerShaderStage'];

class GpuPicture {
  /** Opens WebGPU; `null` where the browser has none. */
  static async open() {
    try {
      const { gpu } = navigator;
      const adapter = (await gpu?.requestAdapter()) ?? (await gpu?.requestAdapter({ forceFallbackAdapter: true }));
      if (!adapter) return null;
      return new GpuPicture(await adapter.requestDevice({
        requiredFeatures: ['shader-f16', 'subgroups'].filter((name) => adapter.features.has(name)),
        requiredLimits: Object.fromEntries(LIMITS.filter((name) => name in adapter.limits).map((name) => [name, adapter.limits[name]])),
      }));
    } catch {
      return null;
    }
  }

  constructor(device) {
    Object.assign(this, { device, api: 'WebGPU', textures: new Map(), uploaded: [] });
    device.lost.then(({ message, reason }) => { this.lost = message || reason; });
    const module = device.createShaderModule({ code: SHOWN_WGSL });
    this.shown = device.createRenderPipeline({
      layout: device.createPipelineLayout({
        bindGroupLayouts: [device.createBindGroupLayout({
          entries: [
            { binding: 0, visibility: GPUShaderStage.FRAGMENT, texture: { sampleType: 'unfilterable-float' } },
            { binding: 1, visibility: GPUShaderStage.FRAGMENT, buffer: {} },
          ],
        })],
      }),
      vertex: { module }, fragment: { module, targets: [{ format: 'rgba8unorm' }] },
    });
    this.srgb = device.createBuffer({ size: 16, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
    // What the samplers of `render` do: the nearest texel, repeated.
    const around = { addressModeU: 'repeat', addressModeV: 'repeat', addressModeW: 'repeat' };
    this.sampler = device.createSampler(around);
  }

  /** Does work, and throws what the device reports of it. */
  async checked(work) {
    const { device } = this;
    if (this.lost !== undefined) throw new Error(`the browser lost WebGPU: ${this.lost}`);
    const kinds = ['validation', 'out-of-memory', 'internal'];
    kinds.forEach((kind) => device.pushErrorScope(kind));
    let result;
    let thrown;
    try {
      result = await work();
    } catch (error) {
      thrown = error;
    }
    const reported = [];
    for (const _ of kinds) reported.push(await device.popErrorScope());
    const [first = thrown] = reported.filter(Boolean);
    if (first) throw new Error(`WebGPU does not take this: ${first.message}`);
    return result;
  }

  async setShader({ webgpu: { Ok: shader, Err: refusal } }) {
    if (refusal !== undefined) throw new Error(`does not run on WebGPU: ${refusal}`);
    const { device } = this;
    const modules = [shader.vertex, shader.fragment].map((code) => device.createShaderModule({ code }));
    const { messages } = await modules[1].getCompilationInfo();
    const wrong = messages.find(({ type }) => type === 'error');
    if (wrong) throw new Error(`WebGPU does not compile the shader: line ${wrong.lineNum}: ${wrong.message}`);
    const { blocks, textures, samplers } = shader;
    // By group: binding, type, and what is bound there.
    const bound = [
      ...blocks.map(([group, binding, type], at) => ({ group, binding, buffer: { type }, from: ['buffers', at] })),
      ...textures.map(([group, binding], at) => ({ group, binding, texture: { sampleType: 'unfilterable-float' }, from: ['images', at] })),
      ...samplers.map(([group, binding]) => ({ group, binding, sampler: { type: 'non-filtering' }, from: null })),
    ];
    const most = Math.max(-1, ...bound.map(({ group }) => group));
    const groups = Array.from({ length: most + 1 }, (_, group) => bound.filter((one) => one.group === group));
    await this.checked(async () => {
      const layouts = groups.map((entries) => device.createBindGroupLayout({
        entries: entries.map(({ from, group, ...entry }) => ({ ...entry, visibility: GPUShaderStage.FRAGMENT })),
      }));
      const { attributes } = shader;
      this.pipelineOf = (components) => {
        let offset = 8;
        const inputs = attributes.map((input, at) => {
          const format = components[input] === 1 ? 'float32' : `float32x${components[input]}`;
          const attribute = { shaderLocation: at + 1, offset, format };
          offset += 4 * components[input];
          return attribute;
        });
        const place = { shaderLocation: 0, offset: 0, format: 'float32x2' };
        return device.createRenderPipelineAsync({
          layout: device.createPipelineLayout({ bindGroupLayouts: layouts }),
          vertex: { module: modules[0], buffers: [{ arrayStride: offset, attributes: [place, ...inputs] }] },
          primitive: { topology: 'point-list' },
          fragment: { module: modules[1], entryPoint: shader.entry, targets: [{ format: 'rgba32float' }] },
          // A shader may write depths; none is compared.
          depthStencil: { format: 'depth32float', depthCompare: 'always', depthWriteEnabled: false },
        });
      };
      Object.assign(this, { groups, layouts, attributes });
      // What is framed has the inputs of this shader.
      if (this.framed) this.pipeline = await this.pipelineOf(this.frame.components);
    });
  }

  async setFrame({ pixels, materials, inputs }, [width, height]) {
    const { device } = this;
    const [at, kinds] = [wordsOf(pixels), wordsOf(materials)];
    const values = inputs.map(([components, numbers]) => [components, floatsOf(numbers)]);
    const components = inputs.map(([count]) => count);
    const given = this.attributes.map((input) => values[input]);
    const stride = 2 + given.reduce((sum, [count]) => sum + count, 0);
    // Those of a material one after the other.
    const order = [...at.keys()].sort((a, b) => kinds[a] - kinds[b] || a - b);
    const points = new Float32Array(stride * at.length);
    const draws = [];
    order.forEach((one, number) => {
      const [column, row] = [at[one] % width, Math.floor(at[one] / width)];
      let to = stride * number;
      points[to] = (2 * column + 1) / width - 1;
      points[to + 1] = 1 - (2 * row + 1) / height;
      to += 2;
      for (const [count, numbers] of given) {
        for (let c = 0; c < count; c += 1) points[to + c] = numbers[one * count + c];
        to += count;
      }
      if (draws.at(-1)?.material === kinds[one]) draws.at(-1).count += 1;
      else draws.push({ material: kinds[one], first: number, count: 1 });
    });
    const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_SRC;
    await this.checked(async () => {
      [this.points, this.lit, this.depth, this.codes, this.copied].forEach((old) => old?.destroy());
      this.points = this.buffer(new Uint8Array(points.buffer), GPUBufferUsage.VERTEX);
      this.lit = device.createTexture({ size: [width, height], format: 'rgba32float', usage });
      this.depth = device.createTexture({ size: [width, height], format: 'depth32float', usage: GPUTextureUsage.RENDER_ATTACHMENT });
      this.codes = device.createTexture({ size: [width, height], format: 'rgba8unorm', usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.COPY_SRC });
      // Rows of a copy are multiples of 256 bytes.
      const bytesPerRow = Math.ceil(width / 64) * 256;
      this.copied = device.createBuffer({ size: bytesPerRow * height, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
      this.showing = device.createBindGroup({
        layout: this.shown.getBindGroupLayout(0),
        entries: [{ binding: 0, resource: this.lit.createView() }, { binding: 1, resource: { buffer: this.srgb } }],
      });
      this.frame = { components, draws, width, height, bytesPerRow };
      this.pipeline = await this.pipelineOf(components);
    });
    Object.assign(this, { used: draws.map(({ material }) => material), fragments: at.length, pixels: new Set(at) });
  }

  /** A buffer with these bytes. */
  buffer(bytes, usage) {
    const buffer = this.device.createBuffer({ size: Math.max(16, Math.ceil(bytes.length / 4) * 4), usage: usage | GPUBufferUsage.COPY_DST });
    const padded = new Uint8Array(Math.ceil(bytes.length / 4) * 4);
    padded.set(bytes);
    this.device.queue.writeBuffer(buffer, 0, padded);
    return buffer;
  }

  image({ width, height, texels }) {
    const texture = this.device.createTexture({
      size: [width, height], format: 'rgba32float', usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
    });
    this.device.queue.writeTexture({ texture }, bytesOf(texels), { bytesPerRow: 16 * width }, [width, height]);
    return texture;
  }

  /** The bytes of the blocks and the textures of each material. */
  async setMaterials(materials) {
    const { device } = this;
    await this.checked(() => {
      this.uploaded.forEach((buffer) => buffer.destroy());
      this.uploaded = [];
      const kept = this.textures;
      this.textures = new Map();
      const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.STORAGE;
      this.bound = materials.map(({ blocks, textures }) => {
        const buffers = blocks.map((bytes) => {
          const buffer = this.buffer(bytes, usage);
          this.uploaded.push(buffer);
          return { buffer, size: Math.max(4, Math.ceil(bytes.length / 4) * 4) };
        });
        const images = textures.map((image) => {
          const texture = this.textures.get(image.texels) ?? kept.get(image.texels) ?? this.image(image);
          this.textures.set(image.texels, texture);
          return texture.createView();
        });
        const all = { buffers, images };
        return this.groups.map((entries, group) => device.createBindGroup({
          layout: this.layouts[group],
          entries: entries.map(({ binding, from }) => ({ binding, resource: from ? all[from[0]][from[1]] : this.sampler })),
        }));
      });
      kept.forEach((texture, key) => this.textures.has(key) || texture.destroy());
    });
  }

  /**
   * Draws the scene and returns its picture. Pixels are read back: without a GPU for the
   * browser's compositor, Chromium ends WebGPU at the first canvas of it.
   */
  async draw(background, srgb) {
    const { device, frame: { width, height, bytesPerRow } } = this;
    device.queue.writeBuffer(this.srgb, 0, new Uint32Array([srgb ? 1 : 0, 0, 0, 0]));
    await this.checked(() => {
      const encoder = device.createCommandEncoder();
      const [r, g, b] = background;
      const lighting = encoder.beginRenderPass({
        colorAttachments: [{ view: this.lit.createView(), clearValue: { r, g, b, a: 1 }, loadOp: 'clear', storeOp: 'store' }],
        depthStencilAttachment: { view: this.depth.createView(), depthClearValue: 1, depthLoadOp: 'clear', depthStoreOp: 'discard' },
      });
      lighting.setPipeline(this.pipeline);
      lighting.setVertexBuffer(0, this.points);
      for (const { material, first, count } of this.frame.draws) {
        this.bound[material].forEach((group, at) => lighting.setBindGroup(at, group));
        lighting.draw(count, 1, first);
      }
      lighting.end();
      const showing = encoder.beginRenderPass({
        colorAttachments: [{ view: this.codes.createView(), loadOp: 'clear', storeOp: 'store' }],
      });
      showing.setPipeline(this.shown);
      showing.setBindGroup(0, this.showing);
      showing.draw(3);
      showing.end();
      encoder.copyTextureToBuffer({ texture: this.codes }, { buffer: this.copied, bytesPerRow }, [width, height]);
      device.queue.submit([encoder.finish()]);
    });
    await this.copied.mapAsync(GPUMapMode.READ);
    const rows = new Uint8Array(this.copied.getMappedRange());
    const image = new ImageData(width, height);
    for (let row = 0; row < height; row += 1) {
      const from = row * bytesPerRow;
      image.data.set(rows.subarray(from, from + 4 * width), row * 4 * width);
    }
    this.copied.unmap();
    return image;
  }

  /** The light of a pixel; `null` where nothing is drawn. */
  async read(column, row) {
    const { device, frame: { width } } = this;
    if (!this.pixels.has(row * width + column)) return null;
    const buffer = device.createBuffer({ size: 256, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    try {
      await this.checked(async () => {
        const encoder = device.createCommandEncoder();
        encoder.copyTextureToBuffer({ texture: this.lit, origin: [column, row] }, { buffer, bytesPerRow: 256 }, [1, 1]);
        device.queue.submit([encoder.finish()]);
        await buffer.mapAsync(GPUMapMode.READ);
      });
      return [...new Float32Array(buffer.getMappedRange()).slice(0, 3)];
    } finally {
      buffer.destroy();
    }
  }
}
