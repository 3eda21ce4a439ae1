// What answers the page's questions: WebAssembly in the page, or the server that it came from.

/** WebAssembly of `landfall-web`: JSON in, JSON out. */
class WasmEngine {
  constructor(module) {
    this.module = module;
  }

  /** The engine in an element of the page: base64 of gzip. */
  static async load(id) {
    const element = document.getElementById(id);
    const packed = Uint8Array.from(atob(element.textContent), (c) => c.charCodeAt(0));
    element.remove();
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
    const engine = new WasmEngine(await WebAssembly.compile(await new Response(stream).arrayBuffer()));
    await engine.begin();
    return engine;
  }

  async begin() {
    this.instance = await WebAssembly.instantiate(this.module, {});
  }

  /** The text of the answers to a request. */
  answer(request) {
    if (!this.instance) throw new Error('the engine starts again');
    const { memory, allocate, answer, release } = this.instance.exports;
    try {
      const given = new TextEncoder().encode(JSON.stringify(request));
      const at = allocate(given.length);
      new Uint8Array(memory.buffer, at, given.length).set(given);
      const result = answer(at, given.length);
      const view = new DataView(memory.buffer);
      const found = new Uint8Array(memory.buffer, view.getUint32(result, true), view.getUint32(result + 4, true));
      const answers = new TextDecoder().decode(found);
      release(result);
      return answers;
    } catch (error) {
      // Its memory may be in any state.
      this.instance = null;
      this.begin();
      throw new Error(`landfall failed on this shader, which is a bug in landfall (${error.message})`);
    }
  }
}

/** The engine of the page itself, and the one that runs functions, which is unpacked when it is asked. */
class LocalEngine {
  async begin() {
    this.layout = await WasmEngine.load('layout-engine');
  }

  answer(request) {
    const runs = request.want.some(({ kind }) => ['run', 'functions', 'scene'].includes(kind));
    if (!runs) return this.layout.answer(request);
    if (this.evaluator) return this.evaluator.answer(request);
    this.loading ??= WasmEngine.load('evaluator').then((engine) => { this.evaluator = engine; });
    return this.loading.then(() => this.evaluator.answer(request));
  }
}

/** `landfall serve`. */
class ServerEngine {
  async begin() {}

  async answer(request) {
    const headers = { 'Content-Type': 'application/json' };
    let response;
    try {
      response = await fetch('answer', { method: 'POST', headers, body: JSON.stringify(request) });
    } catch {
      throw new Error('landfall serve has ended: start it again');
    }
    if (!response.ok) throw new Error(`landfall serve refuses the request (${response.status})`);
    return response.text();
  }

  /** Writes a scene back to its file. */
  async save(path, text) {
    const response = await fetch('save', {
      method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ path, text }),
    });
    const why = response.ok ? await response.text() : `landfall serve refuses to save (${response.status})`;
    if (why !== '') throw new Error(why);
  }

  /** The named files if they have changed since a version. */
  async files(version) {
    const response = await fetch(version === undefined ? 'files' : `files?since=${version}`);
    if (!response.ok) throw new Error(`landfall serve refuses the request (${response.status})`);
    return response.json();
  }
}
