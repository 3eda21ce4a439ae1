// The lights of a scene under one's hands: the scene drawn by the shader of the editor, its lights as
// controls, and the bytes that each control writes.

const SCENE = {
  name: 'six lamps',
  size: [640, 400],
  background: 0.03,
  camera: { position: [0, 2.2, 5.5], front: [0, -0.3, -1], up: [0, 1, 0], fov: 50, near: 0.1, far: 100 },
  lights: {
    ambient: { color: [0.02, 0.02, 0.03], intensity: 1 },
    point: [[1, 0.35, 0.2], [0.2, 1, 0.4], [0.3, 0.45, 1], [1, 0.85, 0.3], [0.9, 0.3, 1], [0.3, 0.95, 1]].map((color, at) => ({
      position: [Number((2.4 * Math.cos(at * 1.047)).toFixed(2)), at % 2 ? 1.1 : 0.5, Number((2.4 * Math.sin(at * 1.047)).toFixed(2))],
      color, intensity: 4, attenuation: { constant: 1, linear: 0.7, quadratic: 1.8 },
    })),
  },
  materials: [{ name: 'plain', diffuse: 1, specular: 0, shininess: 1 }],
  objects: [
    { mesh: 'plane', position: [0, -0.5, 0], scale: 10 },
    { mesh: 'sphere', position: [0, 0.2, 0], scale: 1.4 },
    { mesh: 'cube', position: [-1.7, 0, -0.8], rotation: { axis: [0, 1, 0], degrees: 30 } },
    { mesh: 'cube', position: [1.8, 0, -0.5], rotation: { axis: [0, 1, 0], degrees: -20 } },
  ],
};

const KINDS = ['directional', 'point', 'spot'];
const SKIPS = { '': 'nothing', used: 'unused slots', gates: 'gates', 'tiles=8': 'tiles of 8 pixels' };
const TERMS = ['color', 'ambient', 'diffuse', 'specular'];
/** Lights that are buttons; more are a list that can be searched. */
const MAX_BUTTONS = 12;
/** Lights that all have a ring at first. */
const MAX_RINGS = 32;
const RINGS = { all: 'all', one: 'the light in hand', none: 'none' };
/** Pixels of the picture while the camera moves. */
const QUICK = 160 * 100;

const triple = (value) => (Array.isArray(value) ? value : [value, value, value]).map(Number);
const rounded = (value) => Number(value.toFixed(4));
const minus = (a, b) => a.map((x, at) => x - b[at]);
const plus = (a, b, k = 1) => a.map((x, at) => x + k * b[at]);
const dot = (a, b) => a.reduce((sum, x, at) => sum + x * b[at], 0);
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (a) => a.map((x) => x / Math.sqrt(dot(a, a)));
const coded = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const linear = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);

/** Right, up and front of a camera. */
function axes({ front, up }) {
  const f = unit(front);
  const right = unit(cross(f, up));
  return { f, right, top: cross(right, f) };
}

class LightsTab {
  constructor(page) {
    Object.assign(this, { page, name: 'Lights', chosen: ['point', 0], off: new Map(), distances: new Map(), asked: null, views: [], files: [], path: 'scene.json' });
    this.canvas = el('canvas', { 'aria-label': 'The scene, drawn by the shader', role: 'img' });
    this.stage = el('div', { class: 'stage' }, this.canvas);
    this.facts = el('p', { class: 'note', role: 'status' });
    this.probe = el('p', { class: 'note probe' });
    this.list = el('div', { class: 'lights', role: 'group', 'aria-label': 'Lights' });
    this.search = el('input', { type: 'search', autocomplete: 'off', spellcheck: 'false', 'aria-label': 'Find a light', placeholder: 'Find: 17, spot, off', on: { input: () => this.listed() } });
    this.controls = el('div', { class: 'controls' });
    this.maps = el('div', { class: 'written' });
    this.bytes = el('details', { open: true, on: { toggle: () => this.bytes.open && this.picture && this.written(this.before) } }, el('summary', {}, 'Bytes that are written'), this.maps);
    this.srgb = el('input', { type: 'checkbox', on: { change: () => this.ask({}) } });
    this.skip = choice('Skip', SKIPS, () => this.ask({}));
    this.rings = choice('Rings', RINGS, () => this.handles());
    const file = el('input', { type: 'file', multiple: true, on: { change: () => this.read([...file.files]) } });
    this.panel = el('div', {}, el('div', { class: 'tools' },
      el('label', { class: 'file', title: 'A scene and its shader, meshes and textures; they can be dropped here, too' }, file, 'Open scene…'),
      el('button', { type: 'button', on: { click: () => this.save() } }, 'Save scene'),
      el('button', { type: 'button', on: { click: () => this.turn(-0.15, 0) } }, '← Turn'),
      el('button', { type: 'button', on: { click: () => this.turn(0.15, 0) } }, 'Turn →'),
      el('button', { type: 'button', on: { click: () => this.turn(0, 0.1) } }, 'Up'),
      el('button', { type: 'button', on: { click: () => this.turn(0, -0.1) } }, 'Down'),
      el('label', {}, this.srgb, ' sRGB'), this.skip.element, this.rings.element),
    el('div', { class: 'bench' }, el('div', { class: 'seen' }, this.stage, this.facts, this.probe),
      el('div', { class: 'hands' }, this.list, this.controls, this.bytes)));
    this.panel.addEventListener('drop', (event) => {
      event.preventDefault();
      event.stopPropagation();
      this.read([...event.dataTransfer.files]);
    });
    this.canvas.addEventListener('pointerdown', (event) => this.orbit(event));
    this.canvas.addEventListener('pointermove', (event) => event.buttons === 0 && this.point(event));
    // The curve is painted in the colours of the scheme.
    window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      if (!this.drawn) return;
      this.fields();
      this.handles();
    });
    this.scene = structuredClone(SCENE);
    this.given = `${JSON.stringify(SCENE, null, 2)}\n`;
  }

  want() { return []; }

  /** The text of the shader or an option has changed, or the tab was opened. */
  show() { this.ask({ shader: true, frame: true }); }

  /** The text has changed, but no layout. */
  same() { this.ask({ shader: true }); }

  get text() { return JSON.stringify(this.lit()); }

  /** The scene without the lights that are turned off. */
  lit() {
    const scene = structuredClone(this.scene);
    for (const kind of KINDS) {
      const all = scene.lights?.[kind];
      if (all) scene.lights[kind] = all.filter((_, at) => !this.off.get(`${kind} ${at}`));
    }
    return scene;
  }

  /** Asks the engine for parts of the scene; one question at a time, what came in between at once. */
  async ask(parts) {
    this.asked = { ...this.asked, ...parts };
    if (this.busy) return;
    this.busy = true;
    while (this.asked) {
      const { shader = false, frame = false, quick = false, points = false, probe } = this.asked;
      this.asked = null;
      try {
        await this.draw({ shader, frame, quick, points, probe });
      } catch (error) {
        this.page.problem(error.message);
      }
    }
    this.busy = false;
  }

  async draw({ shader, frame, quick, points, probe }) {
    const [width, height] = this.scene.size;
    const scale = quick ? Math.min(1, Math.sqrt(QUICK / (width * height))) : 1;
    const size = [width, height].map((n) => Math.max(1, Math.round(n * scale)));
    const request = this.page.request();
    const map = shader ? [{ kind: 'map' }] : [];
    const scene = { kind: 'scene', path: this.path, scene: this.text, assets: this.files, size, shader, frame, points, probe: probe ?? null, skip: this.skip.select.value || null };
    const text = await this.page.engine.answer({ ...request, gather: true, want: [...map, scene] });
    const { error, answers } = JSON.parse(text);
    if (error) throw new Error(error);
    const drawn = answers.at(-1);
    this.page.problem(drawn.size ? '' : drawn.findings);
    this.isBusy(false);
    if (!drawn.size) return;
    if (drawn.points) this.unfold(drawn.points);
    if (shader) this.layouts(answers[0], drawn.blocks);
    if (drawn.frame) this.frame = [drawn.frame, drawn.size];
    if (drawn.shader) await this.take(drawn.shader, Boolean(drawn.frame));
    if (!this.frame) return;
    if (this.frame !== this.picture.framed) {
      await this.picture.setFrame(...this.frame);
      this.picture.framed = this.frame;
    }
    const bytes = drawn.materials.map(({ blocks }) => blocks.map(bytesOf));
    await this.picture.setMaterials(drawn.materials.map(({ textures }, at) => ({ blocks: bytes[at], textures })));
    this.put(await this.picture.draw(drawn.background, this.srgb.checked));
    Object.assign(this, { camera: drawn.camera, drawn });
    this.written(bytes);
    if (shader) {
      this.listed();
      this.fields();
    }
    // They say whether the light in hand is in the picture, beside its fields.
    this.handles();
    this.facts.textContent = this.caption(size);
    if (probe) await this.probed(probe, drawn.probe);
    this.canvas.dataset.drawn = String(Number(this.canvas.dataset.drawn ?? 0) + 1);
  }

  /** What is drawn, as a person counts it. */
  caption(size) {
    const { picture: { api, fragments }, drawn: { slots, evaluated, skipping } } = this;
    const { lights } = this.lit();
    const counts = KINDS.map((kind, at) => {
      const count = (lights?.[kind]?.length ?? 0) + (kind === 'point' ? this.random?.count ?? 0 : 0);
      const most = slots[at] === null || slots[at] === count ? '' : `, of at most ${slots[at].toLocaleString('en')}`;
      return count > 0 && `${counted(count, `${kind} light`)}${most}`;
    });
    return [
      this.path.split('/').at(-1), ...counts, `${size.join(' × ')}`, `drawn by ${api}`, counted(fragments, 'fragment'), `${counted(evaluated, 'light')} evaluated in each`,
      skipping && `with the plan of landfall render --skip: ${counted(skipping[0], 'evaluation')}, ${(skipping[1] - skipping[0]).toLocaleString('en')} skipped`,
    ].filter(Boolean).join(' · ');
  }

  /** Shows that the picture is not of what is chosen yet. */
  isBusy(busy) {
    this.stage.classList.toggle('busy', busy);
    this.stage.setAttribute('aria-busy', String(busy));
    if (busy) this.facts.textContent = `Drawing ${this.path.split('/').at(-1)} …`;
  }

  /** Takes a shader: WGSL by WebGPU where the browser has it, the rest by WebGL 2. */
  async take(shader, framed) {
    if ((await this.gpu)?.lost !== undefined) this.gpu = null;
    const gpu = shader.webgpu && await (this.gpu ??= GpuPicture.open());
    this.picture = gpu || (this.gl ??= new GlPicture());
    const inputs = JSON.stringify(shader.inputs);
    if (inputs !== this.inputs) {
      // Other inputs need other values.
      [this.gl, gpu].filter(Boolean).forEach((picture) => { picture.framed = null; });
      if (!framed) {
        this.frame = null;
        this.ask({ shader: true, frame: true });
      }
    }
    this.inputs = inputs;
    await this.picture.setShader(shader, this.views.map(own));
  }

  /** Puts a picture, a canvas or the pixels themselves, onto the page. */
  put(drawn) {
    const { canvas } = this;
    const { width, height } = drawn;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    this.stage.style.setProperty('--aspect', String(width / height));
    const context = canvas.getContext('2d', { alpha: false });
    if (drawn instanceof ImageData) context.putImageData(drawn, 0, 0);
    else context.drawImage(drawn, 0, 0);
  }

  /** Finds the maps of the blocks that are written. */
  layouts(map, blocks) {
    TEXTS.splice(0, TEXTS.length, ...map.texts);
    const known = map.shaders[0].blocks;
    this.views = blocks.map(([name, instance]) => known.find((block) => block.name === name && (block.instance ?? '') === instance));
    this.before = null;
    this.state = { colours: new Map(), opened: new Map() };
  }

  /** Shows the bytes of the blocks, and those that differ from before. */
  written(bytes) {
    const { before } = this;
    this.before = bytes;
    if (!this.bytes.open) return;
    const first = this.picture.used[0] ?? 0;
    const maps = this.views.map((block, number) => {
      const layout = own(block);
      if (!layout || this.drawn.materials.length === 0) return null;
      const now = bytes[first][number];
      const ranges = before ? changed(before[first]?.[number] ?? now, now, layout) : [];
      const mark = ({ start, end }) => (ranges.some(([from, to]) => start < to && end > from)
        ? { class: 'fresh', text: 'written', short: 'written' } : null);
      if (ranges.length > 0) {
        const path = ownerOf(layout, ranges[0][0], now.length).leaf;
        const index = /^(.*)\[(\d+)\]/.exec(path ?? '');
        if (index) this.state.opened.set(index[1], new Set([Number(index[2])]));
      }
      const title = [block.name, block.instance].filter(Boolean).join(' ');
      const told = ranges.map(([from, to]) => `${from}–${to - 1}`).join(', ');
      return el('div', { data: { block: block.name, ranges: ranges.map(([from, to]) => `${from}-${to}`).join(' ') } },
        el('h3', {}, title), el('p', { class: 'note', 'aria-live': 'polite' }, told ? `written: bytes ${told}` : `${now.length} bytes`),
        memoryMap(layout, {
          view: new DataView(now.buffer, now.byteOffset, now.byteLength), state: this.state, mark,
          label: `Bytes of ${title}`, changed: () => this.written(bytes),
        }));
    });
    this.maps.replaceChildren(...maps.filter(Boolean));
  }

  get light() { return this.scene.lights?.[this.chosen[0]]?.[this.chosen[1]]; }

  /** The lights that the scene makes from a seed. */
  get random() {
    const lights = this.scene.generate?.lights;
    return lights && !lights.omit ? lights : null;
  }

  /** Writes random lights into the scene one by one; its cubes stay where they are. */
  unfold(points) {
    const { random } = this;
    if (!random) return;
    const lights = (this.scene.lights ??= {});
    lights.point ??= [];
    lights.point.push(...points.slice(points.length - random.count));
    random.omit = true;
    if (lights.point.length > MAX_RINGS) this.rings.select.value = 'one';
    this.listed();
    this.fields();
  }

  /** The list of lights. */
  listed() {
    const all = KINDS.flatMap((kind) => (this.scene.lights?.[kind] ?? []).map((_, at) => [kind, at]));
    if (!this.light && all.length > 0) [this.chosen] = all;
    const isChosen = ([kind, at]) => kind === this.chosen[0] && at === this.chosen[1];
    const named = ([kind, at]) => `${kind} ${at}${this.off.get(`${kind} ${at}`) ? ' (off)' : ''}`;
    const buttons = all.length <= MAX_BUTTONS ? all.map((one) => el('button', {
      type: 'button', class: 'plain', 'aria-pressed': String(isChosen(one)), data: { ends: ends(this.lightAt(one)) }, on: { click: () => this.choose(...one) },
    }, named(one))) : this.found(all.filter((one) => named(one).includes(this.search.value.trim())), named, isChosen, all.length);
    const [kind] = this.chosen;
    const slots = this.drawn.slots[KINDS.indexOf(kind)];
    const count = this.scene.lights?.[kind]?.length ?? 0;
    this.list.replaceChildren(...buttons,
      ...(this.random ? [el('button', { type: 'button', class: 'plain', on: { click: () => this.ask({ points: true }) } }, `Edit ${counted(this.random.count, 'random light')}`)] : []),
      el('button', { type: 'button', class: 'plain', disabled: !this.light || slots !== null && count >= slots, on: { click: () => this.add() } }, `Add ${kind}`),
      el('button', { type: 'button', class: 'plain', disabled: count === 0, on: { click: () => this.remove() } }, 'Remove'));
  }

  lightAt([kind, at]) {
    return this.scene.lights?.[kind]?.[at];
  }

  /** Shows in the list where the light in hand ends. */
  ended() {
    const told = ends(this.light);
    const button = this.list.querySelector('[aria-pressed=true]');
    if (button) button.dataset.ends = told;
    const option = this.list.querySelector('select')?.selectedOptions[0];
    if (option) option.textContent = [option.value, told].filter(Boolean).join(' · ');
  }

  /** A list of many lights with its search. */
  found(all, named, isChosen, of) {
    const select = el('select', { size: '6', 'aria-label': 'Lights', on: { change: () => this.choose(...all[select.selectedIndex]) } },
      all.map((one) => el('option', { selected: isChosen(one), value: named(one) }, [named(one), ends(this.lightAt(one))].filter(Boolean).join(' · '))));
    return [this.search, el('span', { class: 'note' }, `${all.length.toLocaleString('en')} of ${of.toLocaleString('en')}`), select];
  }

  choose(kind, at) {
    const isListed = this.list.contains(document.activeElement) && document.activeElement.localName === 'select';
    this.chosen = [kind, at];
    this.listed();
    this.fields();
    this.handles();
    if (isListed) this.list.querySelector('select')?.focus();
  }

  add() {
    const [kind, at] = this.chosen;
    const all = this.scene.lights[kind];
    all.push(structuredClone(all[at]));
    this.choose(kind, all.length - 1);
    this.ask({});
  }

  remove() {
    const [kind, at] = this.chosen;
    this.scene.lights[kind].splice(at, 1);
    this.off.clear();
    this.choose(kind, Math.max(0, at - 1));
    this.ask({});
  }

  /** A number of the light with a slider; `get` and `set` reach it. A logarithmic one begins with 0. */
  slider(label, { get, set, min = 0, max, step = 0.01, logarithmic = false }) {
    const place = (value) => (logarithmic ? Math.max(0, 1000 * (Math.log(value / min) / Math.log(max / min))) : value);
    const value = (at) => {
      if (!logarithmic) return Number(at);
      return Number(at) === 0 ? 0 : Number((min * (max / min) ** (at / 1000)).toPrecision(3));
    };
    const shown = () => (logarithmic ? Number(get().toPrecision(4)) : rounded(get()));
    const number = el('input', { type: 'number', step: logarithmic ? 'any' : step, 'aria-label': label, data: { field: label } });
    const range = el('input', { type: 'range', ...(logarithmic ? { min: 0, max: 1000, step: 1 } : { min, max, step }), 'aria-label': `${label}, slider`, data: { field: label } });
    const refresh = () => {
      if (document.activeElement !== number) number.value = String(shown());
      if (document.activeElement !== range) range.value = String(place(get()));
      range.setAttribute('aria-valuetext', String(shown()));
    };
    const write = (given) => {
      if (!Number.isFinite(given)) return;
      set(given);
      refresh();
      this.ended();
      this.ask({});
    };
    range.addEventListener('input', () => write(value(range.value)));
    number.addEventListener('input', () => number.value !== '' && write(Number(number.value)));
    refresh();
    return { element: el('div', { class: 'field' }, el('span', {}, label), range, number), refresh };
  }

  /** The controls of the chosen light. */
  fields() {
    const { light } = this;
    if (!light) {
      const { random } = this;
      this.controls.replaceChildren(el('p', { class: 'note' }, random
        ? `The scene makes ${counted(random.count, 'point light')} from a seed. “Edit” writes them into the scene one by one.` : 'The scene has no lights.'));
      return;
    }
    const parts = [];
    const key = this.chosen.join(' ');
    const on = el('input', { type: 'checkbox', checked: !this.off.get(key), on: { change: () => {
      this.off.set(key, !on.checked);
      this.listed();
      this.ask({});
    } } });
    parts.push(el('h3', {}, key), el('label', {}, on, ' On'), this.outside = el('p', { class: 'note' }));
    for (const name of TERMS.filter((one) => typeof light[one] === 'number' || Array.isArray(light[one]))) {
      const scale = () => Math.max(1, ...triple(light[name]));
      const hexes = triple(light[name]).map((x) => Math.round(255 * coded(Math.max(0, x / scale()))).toString(16).padStart(2, '0'));
      const picker = el('input', { type: 'color', value: `#${hexes.join('')}`, on: { input: () => {
        const k = scale();
        light[name] = [1, 3, 5].map((from) => rounded(k * linear(parseInt(picker.value.slice(from, from + 2), 16) / 255)));
        this.ask({});
      } } });
      parts.push(el('label', { class: 'field' }, el('span', {}, name), picker));
    }
    if (typeof light.intensity === 'number') {
      parts.push(this.slider('intensity', { get: () => light.intensity, set: (value) => { light.intensity = value; }, max: Math.max(4, 2 * light.intensity) }).element);
    }
    for (const [name, span] of [['position', 10], ['direction', 1]]) {
      if (!light[name]) continue;
      ['x', 'y', 'z'].forEach((axis, at) => parts.push(this.slider(`${name} ${axis}`, {
        get: () => light[name][at], set: (value) => { light[name][at] = value; }, min: -span, max: span,
      }).element));
    }
    const { attenuation, cone } = light;
    if (attenuation && COEFFICIENTS.some((name) => typeof attenuation[name] === 'number')) {
      parts.push(...new AttenuationControls(this, light, key).elements);
    }
    if (typeof light.range === 'number') {
      parts.push(this.slider('range', { get: () => light.range, set: (value) => { light.range = value; }, min: 0.01, max: 2 * light.range }).element);
    }
    for (const name of ['inner_degrees', 'outer_degrees', 'half_degrees'].filter((one) => typeof cone?.[one] === 'number')) {
      parts.push(this.slider(name.replace('_', ' '), { get: () => cone[name], set: (value) => { cone[name] = value; }, max: 89, step: 0.1 }).element);
    }
    this.controls.replaceChildren(...parts);
  }

  /** A handle for each light with a position, where the picture shows it. */
  handles() {
    const { camera } = this;
    const { f, right, top } = axes(camera);
    const [width, height] = this.scene.size;
    const half = Math.tan((camera.fov * Math.PI) / 360);
    this.stage.querySelectorAll('.handle').forEach((one) => one !== this.dragged && one.remove());
    const rings = this.rings.select.value;
    const inHand = this.chosen.join(' ');
    let isSeen = !this.light?.position;
    for (const kind of ['point', 'spot']) {
      (this.scene.lights?.[kind] ?? []).forEach((light, at) => {
        if (!light.position || this.off.get(`${kind} ${at}`)) return;
        const to = minus(light.position, camera.position);
        const depth = dot(to, f);
        if (depth <= 0.01) return;
        const x = (dot(to, right) / (depth * half)) * (height / width);
        const y = dot(to, top) / (depth * half);
        if (Math.abs(x) > 1 || Math.abs(y) > 1) return;
        const name = `${kind} ${at}`;
        isSeen ||= name === inHand;
        if (rings === 'none' || rings === 'one' && name !== inHand) return;
        if (this.dragged?.dataset.light === name) {
          this.place(this.dragged, x, y);
          return;
        }
        const handle = el('button', {
          type: 'button', class: 'handle', data: { light: name }, 'aria-label': `Light ${name}; arrow keys move it`,
          'aria-pressed': String(name === inHand),
          on: { click: () => this.choose(kind, at), keydown: (event) => this.nudge(event, kind, at), pointerdown: (event) => this.drag(event, kind, at) },
        });
        this.place(handle, x, y);
        this.stage.append(handle);
      });
    }
    if (this.outside) this.outside.textContent = isSeen || this.off.get(inHand) ? '' : 'It is outside the picture.';
  }

  place(handle, x, y) {
    handle.style.left = `${50 + 50 * x}%`;
    handle.style.top = `${50 - 50 * y}%`;
    // Its name stays within the picture.
    handle.classList.toggle('named-left', x > 0.4);
  }

  /** Moves a light by pixels of the picture, at its distance. */
  move(light, dx, dy) {
    const { f, right, top } = axes(this.camera);
    const depth = dot(minus(light.position, this.camera.position), f);
    const perPixel = (2 * depth * Math.tan((this.camera.fov * Math.PI) / 360)) / this.canvas.clientHeight;
    light.position = plus(plus(light.position, right, dx * perPixel), top, -dy * perPixel).map(rounded);
    this.fields();
    this.ask({});
  }

  nudge(event, kind, at) {
    const by = { ArrowLeft: [-4, 0], ArrowRight: [4, 0], ArrowUp: [0, -4], ArrowDown: [0, 4] }[event.key];
    if (!by) return;
    event.preventDefault();
    this.chosen = [kind, at];
    this.dragged = event.currentTarget;
    this.move(this.scene.lights[kind][at], ...by);
    event.currentTarget.addEventListener('blur', () => { this.dragged = null; }, { once: true });
  }

  drag(event, kind, at) {
    const handle = event.currentTarget;
    handle.setPointerCapture(event.pointerId);
    this.chosen = [kind, at];
    this.dragged = handle;
    this.listed();
    let [x, y] = [event.clientX, event.clientY];
    const move = (moved) => {
      this.move(this.scene.lights[kind][at], moved.clientX - x, moved.clientY - y);
      [x, y] = [moved.clientX, moved.clientY];
    };
    handle.addEventListener('pointermove', move);
    handle.addEventListener('pointerup', () => {
      handle.removeEventListener('pointermove', move);
      this.dragged = null;
    }, { once: true });
  }

  /** Turns the camera around what it looks at. */
  turn(across, up, quick = false) {
    const given = this.scene.camera;
    const { f, right } = axes(given);
    const distance = Math.max(1, -dot(given.position, f));
    const centre = plus(given.position, f, distance);
    const pitch = Math.min(1.5, Math.max(-1.5, Math.asin(f[1]) - up));
    const yaw = Math.atan2(f[2], f[0]) + across;
    if (Math.abs(right[1]) > 0.99) return;
    given.front = [Math.cos(pitch) * Math.cos(yaw), Math.sin(pitch), Math.cos(pitch) * Math.sin(yaw)].map(rounded);
    given.position = plus(centre, unit(given.front), -distance).map(rounded);
    this.ask({ frame: true, quick });
    clearTimeout(this.settling);
    if (quick) this.settling = setTimeout(() => this.ask({ frame: true, quick: false }), 250);
  }

  orbit(event) {
    this.canvas.setPointerCapture(event.pointerId);
    let [x, y] = [event.clientX, event.clientY];
    const move = (moved) => {
      this.turn((moved.clientX - x) / 150, (moved.clientY - y) / -150, true);
      [x, y] = [moved.clientX, moved.clientY];
    };
    this.canvas.addEventListener('pointermove', move);
    this.canvas.addEventListener('pointerup', () => this.canvas.removeEventListener('pointermove', move), { once: true });
  }

  /** Asks for the light under the pointer. */
  point(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = [
      Math.floor(((event.clientX - box.left) / box.width) * this.canvas.width),
      Math.floor(((event.clientY - box.top) / box.height) * this.canvas.height),
    ];
    if (at.every((n, axis) => n >= 0 && n < [this.canvas.width, this.canvas.height][axis])) this.ask({ probe: at });
  }

  async probed([column, row], reference) {
    const light = await this.picture.read(column, row);
    if (!light || !reference) {
      this.probe.textContent = `column ${column}, row ${row}: ${light ? 'the reference is undefined' : 'nothing is drawn'}`;
      return;
    }
    const apart = Math.max(...light.map((x, at) => Math.abs(x - reference[at]))) * 255;
    const shown = (color) => color.map((x) => x.toPrecision(4)).join(', ');
    this.probe.textContent = `column ${column}, row ${row}: ${shown(light)}; f64 reference ${shown(reference)}; `
      + `${apart.toPrecision(2)} steps of 1/255 apart`;
    this.probe.dataset.steps = String(apart);
  }

  /** Opens a scene with its shader and what it names. */
  async read(files) {
    const scene = files.find(({ name }) => name.endsWith('.json'));
    if (!scene) {
      this.page.problem('A scene is a .json file; open its shader with it.');
      return;
    }
    const others = files.filter((one) => one !== scene);
    const assets = await Promise.all(others.map(async (file) => [file.name, base64(new Uint8Array(await file.arrayBuffer()))]));
    const given = await scene.text();
    if (!this.open(scene.name, given, assets)) return;
    const wanted = String(this.scene.shader?.path ?? this.scene.shader ?? '').split('/').at(-1);
    const shader = others.find(({ name }) => name === wanted) ?? others.find(({ name }) => /\.(frag|wgsl|glsl)$/.test(name));
    if (shader) this.page.take(shader.name, await shader.text());
    else this.ask({ shader: true, frame: true });
  }

  /** Takes a scene; the light that was chosen stays so. */
  open(path, given, files) {
    let scene;
    try {
      scene = JSON.parse(given);
    } catch (error) {
      this.page.problem(`${path} is not JSON: ${error.message}`);
      return false;
    }
    Object.assign(this, { path, files, scene, given });
    this.off.clear();
    this.distances.clear();
    this.search.value = '';
    const count = KINDS.reduce((sum, kind) => sum + (scene.lights?.[kind]?.length ?? 0), 0);
    this.rings.select.value = count > MAX_RINGS ? 'one' : 'all';
    this.isBusy(true);
    return true;
  }

  async save() {
    const served = this.page.files.some(({ path, scene }) => path === this.path && scene !== null);
    const wanted = this.lit();
    let text = withValues(this.given, wanted);
    if (!isSame(JSON.parse(text), wanted)) text = `${JSON.stringify(wanted, null, 2)}\n`;
    try {
      if (served) {
        // Before it is seen in the file again.
        this.given = text;
        await this.page.engine.save(this.path, text);
      } else {
        const link = el('a', { download: this.path.split('/').at(-1) });
        link.href = URL.createObjectURL(new Blob([text], { type: 'application/json' }));
        link.click();
        setTimeout(() => URL.revokeObjectURL(link.href), 1000);
      }
    } catch (error) {
      this.page.problem(error.message);
    }
  }
}

/** The layout of a block by its own rules. */
const own = (block) => block?.layouts.find(({ rules }) => rules === block.rules) ?? block?.layouts[0];

/** Bytes in base64. */
function base64(given) {
  let binary = '';
  for (let at = 0; at < given.length; at += 8192) binary += String.fromCharCode(...given.subarray(at, at + 8192));
  return btoa(binary);
}

/** The ranges of bytes that `Buffer` marks dirty when the values that differ are set: whole vectors. */
function changed(before, now, layout) {
  const ranges = [];
  for (let at = 0; at < now.length; at += 4) {
    const same = [0, 1, 2, 3].every((n) => before[at + n] === now[at + n]);
    if (same || at < ranges.at(-1)?.[1]) continue;
    const owner = ownerOf(layout, at, now.length);
    const [from, to] = owner.kind === 'component' ? [owner.leafStart, owner.leafEnd] : [at, at + 4];
    if (ranges.at(-1)?.[1] === from) ranges.at(-1)[1] = to;
    else ranges.push([from, to]);
  }
  return ranges;
}
