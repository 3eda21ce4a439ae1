// The playground: the editor, the options, and the results of the engine as tabs.

const EXAMPLE = `#version 330 core
// Six lights as the tutorials have them. Type: the maps follow.
#ifndef LIGHTS
#define LIGHTS 6
#endif

struct PointLight {
    vec3 position;
    float constant;
    vec3 color;
    float linear;
    float quadratic;
};

layout(std140) uniform Lights {
    PointLight lights[LIGHTS];
    vec3 ambient;
    int count;
};

in vec3 fragPosition;
in vec3 normal;
out vec4 color;

float attenuation(PointLight light, float distance) {
    return 1.0 / (light.constant + light.linear * distance + light.quadratic * distance * distance);
}

void main() {
    vec3 n = normalize(normal);
    vec3 sum = ambient;
    for (int i = 0; i < min(count, LIGHTS); i++) {
        vec3 to = lights[i].position - fragPosition;
        float diffuse = max(dot(n, normalize(to)), 0.0);
        sum += lights[i].color * diffuse * attenuation(lights[i], length(to));
    }
    color = vec4(sum, 1.0);
}
`;

/** Blocks that are drawn at once; the others as they come into view. */
const AT_ONCE = 6;
/** Time of an update in milliseconds from which typing is not followed key by key. */
const SLOW = 100;
/** Milliseconds to the next question to a server that is gone, or that cannot keep the page waiting. */
const PAUSE = 1000;

/** The values of the option `kind` for stages of GLSL. */
const KINDS_OF_STAGES = { fragment: 'frag', vertex: 'vert', compute: 'comp' };
const byId = (id) => document.getElementById(id);
const OPTIONS = ['kind', 'defines', 'target', 'rules', 'gather'];
/** What the page calls the options of the command that messages name. */
const FIELDS = {
  '--args': 'the field “Arguments”', '--data': 'the field “Contents of blocks”', '--input': 'the fields of inputs', '--fn': 'the field “Function”',
  '--rules': 'the field “Rules”', '--target': 'the field “Target”', '--gather': 'the field “Gather loose uniforms”', '-D': 'the field “Macros”',
};

/** A message of the command in the words of the page. */
const inOwnWords = (text) => text.replace(/(`?)(--(?:args|data|input|fn|rules|target|gather)|(?<![\w-])-D)(?![\w-])\1/g, (all, tick, option) => FIELDS[option]);

/** The findings of errors. */
const errorsOf = (findings) => findings.filter((finding) => levelOf(finding) === 'error');

const LAYOUTS = { table: 'Table', listing: 'Listing', json: 'JSON', csv: 'CSV', md: 'Markdown' };

/** A select with its label. */
function choice(label, options, changed) {
  const select = el('select', { on: { change: changed } },
    Object.entries(options).map(([value, name]) => el('option', { value }, name)));
  return { select, element: el('label', {}, label, ' ', select) };
}

/** A text of the command in a box of its own, which the keyboard can scroll. */
const output = (label) => el('pre', { tabindex: '0', role: 'region', 'aria-label': label });

/** Copies a text, and says so on the button. */
async function copied(button, text) {
  const label = (button.label ??= button.textContent);
  let told = 'Copied';
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    told = 'The browser does not let the page copy';
  }
  button.textContent = told;
  setTimeout(() => { button.textContent = label; }, 2000);
}

/** What a command prints: its text, and below it its findings. */
class Printed {
  constructor(label) {
    this.out = output(label);
    this.errors = output(`${label}: findings`);
    this.errors.classList.add('errors');
    this.copy = el('button', { type: 'button', class: 'plain copy', on: { click: () => copied(this.copy, this.out.textContent) } }, `Copy ${label.toLowerCase()}`);
    this.elements = [this.copy, this.out, this.errors];
    this.boxes = [this.out, this.errors];
    this.show({ stdout: '', stderr: '' });
  }

  /** Shows both; the output in the colours of a language, if it is code. */
  show({ stdout, stderr }, language) {
    this.out.replaceChildren(...coloured(plain(stdout), language));
    this.errors.textContent = plain(inOwnWords(stderr));
    this.errors.classList.toggle('error', /^error/m.test(stderr));
    this.out.hidden = stdout === '';
    this.copy.hidden = stdout === '';
    this.errors.hidden = stderr === '';
  }
}

/** The maps of all blocks. */
class MapsTab {
  constructor(page) {
    Object.assign(this, { page, name: 'Maps', views: new Map() });
    this.list = el('div', {});
    const aside = el('aside', { 'aria-label': 'Selected bytes', tabindex: '0' });
    this.detail = new Detail(aside);
    this.panel = el('div', { class: 'with-detail' }, this.list, aside);
    this.seen = new IntersectionObserver((all) => all.filter((one) => one.isIntersecting).forEach(({ target }) => {
      this.seen.unobserve(target);
      if (!target.view.drawn) target.view.draw();
    }), { rootMargin: '300px' });
  }

  want() { return []; }

  show([map]) {
    TEXTS.splice(0, TEXTS.length, ...map.texts);
    const [shader] = map.shaders;
    const before = this.views;
    const [error] = errorsOf(shader.findings ?? []);
    this.views = new Map();
    for (const block of shader.blocks) {
      let key = `${block.name} ${block.instance ?? ''}`;
      while (this.views.has(key)) key += "'";
      const view = new BlockView(block, shader, this.detail);
      if (before.has(key)) view.adopt(before.get(key));
      this.views.set(key, view);
    }
    if (error) this.keep(before, error);
    const views = [...this.views.values()];
    const broken = error ? el('p', { class: 'broken' }, el('span', { class: 'badge error' }, 'error'), ' ', whereIs(error), ': ', prose(error.message), ' ',
      el('button', { type: 'button', class: 'plain', on: { click: () => this.page.choose(this.page.tabs.find((tab) => tab instanceof FindingsTab)) } }, 'Show findings')) : '';
    const note = shader.assumed ? el('p', { class: 'note' }, shader.assumed) : '';
    const none = views.length === 0 ? el('p', { class: 'note' }, 'No blocks.') : '';
    this.list.replaceChildren(broken, note, none, ...views.map((view) => view.element));
    views.filter((view) => !view.isStale).forEach((view, index) => (index < AT_ONCE ? view.draw() : this.seen.observe(view.element)));
  }

  /** Keeps the blocks that an error hides, as they were last and where they were. */
  keep(before, error) {
    const now = this.views;
    this.views = new Map();
    for (const [key, view] of before) {
      if (now.has(key)) this.views.set(key, now.get(key));
      else {
        if (!view.isStale) {
          view.isStale = true;
          if (!view.drawn) view.draw();
          view.element.classList.add('stale');
          // Its texts are those of an answer that is gone: nothing of it can be chosen.
          view.element.inert = true;
          view.element.prepend(view.since = el('p', { class: 'note' }));
        }
        view.since.textContent = `As it was before the error in line ${error.place.line}`;
        this.views.set(key, view);
      }
    }
    for (const [key, view] of now) this.views.set(key, view);
  }
}

/** The findings, each with a button that goes to its place. */
class FindingsTab {
  constructor(page) {
    Object.assign(this, { page, name: 'Findings' });
    this.list = el('ul', { class: 'findings' });
    this.printed = new Printed('As the command prints them');
    this.panel = el('div', {}, this.list, el('details', {}, el('summary', {}, 'As the command prints them'), this.printed.elements));
  }

  want() { return [{ kind: 'check', format: 'human' }]; }

  show([map, check]) {
    const findings = map.shaders.flatMap((shader) => shader.findings ?? []);
    const items = findings.map((finding) => {
      const item = findingItem(finding);
      const { place } = finding;
      if (place.path === this.page.path && place.line > 0) {
        item.append(el('p', {}, el('button', {
          type: 'button', class: 'plain', 'aria-label': `Go to line ${place.line}, column ${place.column}: ${finding.code}`,
          on: { click: () => this.page.editor.goTo(place.line, place.column) },
        }, `Go to line ${place.line}`)));
      }
      return item;
    });
    this.list.replaceChildren(...(items.length > 0 ? items : [el('li', { class: 'note' }, 'No findings.')]));
    this.printed.show(check);
  }
}

/** The layout as `landfall layout` prints it. */
class LayoutTab {
  constructor(page) {
    this.name = 'Layout';
    this.format = choice('Format', LAYOUTS, () => page.update());
    this.printed = new Printed('Layout');
    this.panel = el('div', {}, el('div', { class: 'fields row' }, this.format.element, this.printed.copy), this.printed.boxes);
  }

  want() { return [{ kind: 'layout', format: this.format.select.value }]; }

  show([, layout]) { this.printed.show(layout, this.format.select.value); }
}

/** Generated code. */
class CodeTab {
  constructor(page, languages) {
    this.name = 'Code';
    this.lang = choice('Language', Object.fromEntries(languages), () => page.update());
    this.lang.select.value = 'rust';
    this.printed = new Printed('Generated code');
    this.panel = el('div', {}, el('div', { class: 'fields row' }, this.lang.element, this.printed.copy), this.printed.boxes);
  }

  want() { return [{ kind: 'emit', lang: this.lang.select.value }]; }

  show([, code]) { this.printed.show(code, this.lang.select.value); }
}

/** A call of a function by the interpreter. */
class RunTab {
  constructor(page) {
    this.name = 'Run';
    const changed = () => page.update();
    const written = () => {
      this.written = this.args.value.trim() !== '';
      changed();
    };
    this.function = choice('Function', {}, () => {
      this.written = false;
      changed();
    });
    this.args = el('input', { autocomplete: 'off', spellcheck: 'false', value: '[]', on: { input: written } });
    this.data = el('textarea', { rows: '3', spellcheck: 'false', placeholder: '{"Lights": {"count": 1}}', on: { input: changed } });
    this.inputs = el('div', { class: 'inputs', role: 'group', 'aria-label': 'Inputs of the stage', hidden: true });
    this.changed = changed;
    this.printed = new Printed('Result');
    this.panel = el('div', {}, el('div', { class: 'fields' }, this.function.element,
      el('label', {}, 'Arguments, as a JSON array ', this.args), this.inputs,
      el('label', {}, 'Contents of blocks, as a JSON object; zeros without ', this.data)), this.printed.elements);
  }

  want() {
    const run = {
      kind: 'run', function: this.function.select.value || this.wanted || 'main', args: this.args.value, data: this.data.value, format: 'human',
      inputs: this.given.filter(([, value]) => value.trim() !== ''),
    };
    return [{ kind: 'functions' }, run, { kind: 'inputs' }];
  }

  /** The values of inputs that were written, names and texts: those of a link until they have fields. */
  get given() { return this.linked ?? [...this.inputs.querySelectorAll('input')].map(({ name, value }) => [name, value]); }

  /** A field for each input; what was written stays. */
  fields(inputs) {
    const key = JSON.stringify(inputs);
    if (key === this.shown && !this.linked) return;
    this.shown = key;
    const before = new Map(this.given);
    this.linked = null;
    this.inputs.hidden = inputs.length === 0;
    this.inputs.replaceChildren(...inputs.map(([name, example]) => el('label', {}, `Input ${name} `, el('input', {
      name, autocomplete: 'off', spellcheck: 'false', value: before.get(name) ?? '', placeholder: example, on: { input: this.changed },
    }))));
  }

  show([, functions, result, inputs], page) {
    this.fields(inputs);
    const { select } = this.function;
    const before = select.value || this.wanted;
    select.replaceChildren(...functions.map(([name]) => el('option', { value: name }, name)));
    const chosen = functions.find(([name]) => name === before) ?? functions[0];
    select.value = chosen?.[0] ?? '';
    this.printed.show({ ...result, stdout: inOwnWords(result.stdout) });
    // Arguments that fit stand for those that nobody has written.
    const proposed = chosen && !this.written ? chosen[1] : this.args.value;
    if (select.value === before && proposed === this.args.value) return;
    this.args.value = proposed;
    page.update();
  }
}

class Playground {
  constructor(data, engine) {
    Object.assign(this, { data, engine, files: [], running: false, again: false, took: 0, last: '' });
    this.tabs = [new MapsTab(this), new FindingsTab(this), new LayoutTab(this), new CodeTab(this, data.languages), new RunTab(this), new LightsTab(this)];
    this.tab = this.tabs[0];
    this.buttons = this.tabs.map((tab, index) => this.tabButton(tab, index));
    document.querySelector('.tabs').append(...this.buttons);
    document.querySelector('.panels').append(...this.tabs.map(({ panel }) => panel));
    this.editor = Editor.create(byId('editor'), EXAMPLE, () => this.changed());
    byId('editor').editor = this.editor;
    const wrap = byId('wrap');
    wrap.checked = recalled('localStorage', 'wrap') === 'true';
    this.editor.wraps = wrap.checked;
    wrap.addEventListener('change', () => {
      this.editor.wraps = wrap.checked;
      keep('localStorage', 'wrap', wrap.checked);
    });
    new Divider(byId('divider'));
    byId('results').page = this;
    for (const id of OPTIONS) byId(id).addEventListener('input', () => this.update());
    byId('options').addEventListener('submit', (event) => event.preventDefault());
    byId('file').addEventListener('change', () => this.open(this.files[byId('file').selectedIndex]));
    byId('link').addEventListener('click', () => this.copyLink());
    window.addEventListener('hashchange', () => this.restore());
    document.querySelector('.skip').addEventListener('click', (event) => {
      event.preventDefault();
      byId('results').focus();
    });
    dropping();
  }

  tabButton(tab, index) {
    const [id, panel] = [`tab-${tab.name.toLowerCase()}`, `panel-${tab.name.toLowerCase()}`];
    tab.panel.classList.add('panel');
    tab.panel.prepend(el('h2', { class: 'unseen' }, tab.name));
    for (const [name, value] of Object.entries({ id: panel, role: 'tabpanel', 'aria-labelledby': id })) tab.panel.setAttribute(name, value);
    tab.panel.hidden = index > 0;
    const move = (event) => {
      const to = { ArrowRight: index + 1, ArrowLeft: index - 1 + this.tabs.length, Home: 0, End: this.tabs.length - 1 }[event.key];
      if (to === undefined) return;
      event.preventDefault();
      this.choose(this.tabs[to % this.tabs.length]);
      this.buttons[to % this.tabs.length].focus();
    };
    return el('button', {
      type: 'button', id, role: 'tab', 'aria-controls': panel, 'aria-selected': String(index === 0), tabindex: index === 0 ? '0' : '-1',
      on: { click: () => this.choose(tab), keydown: move },
    }, tab.name);
  }

  choose(tab) {
    this.tab = tab;
    document.body.classList.toggle('lit', tab instanceof LightsTab);
    this.tabs.forEach((one, index) => {
      one.panel.hidden = one !== tab;
      this.buttons[index].setAttribute('aria-selected', String(one === tab));
      this.buttons[index].tabIndex = one === tab ? 0 : -1;
    });
    this.last = '';
    this.update();
  }

  /** The named file of a server that is open, if any. */
  get file() { return this.files.find(({ path }) => path === byId('file').value); }

  get path() { return this.file?.shader ?? `shader.${byId('kind').value}`; }

  request() {
    const { file } = this;
    return {
      path: this.path, text: this.editor.text, files: file?.includes ?? [],
      include_dirs: this.data.server?.include_dirs ?? [],
      defines: byId('defines').value.split(/\s+/).filter(Boolean),
      targets: [byId('target').value].filter(Boolean), rules: byId('rules').value || null, gather: byId('gather').checked,
      want: [{ kind: 'map' }, ...this.tab.want()],
    };
  }

  /** The text was changed. */
  changed() {
    if (this.setting) return;
    this.lasting = '';
    if (this.took < SLOW) this.update();
    else {
      clearTimeout(this.waiting);
      this.waiting = setTimeout(() => this.update(), 250);
    }
  }

  /** Asks the engine and shows its answers; one question at a time. */
  update() {
    if (this.running) {
      this.again = true;
      return;
    }
    const began = performance.now();
    const done = (answers) => {
      this.running = false;
      this.show(answers);
      this.took = performance.now() - began;
      this.remember();
      if (this.again) {
        this.again = false;
        this.update();
      }
    };
    const failed = (error) => {
      this.running = false;
      this.problem(error.message);
      this.last = '';
      if (this.again) {
        this.again = false;
        this.update();
      }
    };
    this.running = true;
    try {
      const answers = this.engine.answer(this.request());
      if (typeof answers === 'string') done(answers);
      else answers.then(done).catch(failed);
    } catch (error) {
      failed(error);
    }
  }

  show(text) {
    if (text === this.last) {
      this.tab.same?.();
      return;
    }
    const { error, answers } = JSON.parse(text);
    this.problem(error ?? '');
    if (error) return;
    this.last = text;
    this.answers = answers;
    const [shader] = answers[0].shaders;
    const findings = shader.findings ?? [];
    // Of a file it is not chosen, but shown.
    if (byId('kind').disabled) byId('kind').value = shader.language === 'wgsl' ? 'wgsl' : KINDS_OF_STAGES[shader.stage] ?? 'glsl';
    byId('summary').textContent = [
      shader.stage ? `${shader.language.toUpperCase()} ${shader.stage}` : shader.language.toUpperCase(),
      counted(shader.blocks.length, 'block'), counted(findings.length, 'finding'), `landfall ${this.data.tool.version}`,
    ].join(' · ');
    this.count(findings);
    this.mark(findings);
    this.tab.show(answers, this);
    document.documentElement.dataset.ready = String(Number(document.documentElement.dataset.ready ?? 0) + 1);
  }

  /** The number of findings on their tab, errors and warnings in their colours. */
  count(findings) {
    const button = byId('tab-findings');
    button.replaceChildren('Findings', ...badges(findings));
  }

  /** Underlines the places of findings. */
  mark(findings) {
    const { doc } = this.editor.view.state;
    const at = (number, column) => {
      const line = doc.line(Math.min(Math.max(number, 1), doc.lines));
      const before = [...line.text].slice(0, column - 1).join('');
      return Math.min(line.from + before.length, line.to);
    };
    const marks = findings.filter(({ place }) => place.path === this.path && place.line > 0).map(({ place, level, code, message }) => {
      let from = at(place.line, place.column);
      let to = at(place.end_line, place.end_column);
      if (to <= from) {
        // A place between letters, such as the end of the text: the last letter before it.
        from = Math.max(0, doc.sliceString(0, from).trimEnd().length - 1);
        to = Math.min(from + 1, doc.length);
      }
      return { from, to, level: level === 'deny' ? 'error' : 'warning', text: plain(`${code}: ${message}`) };
    });
    this.editor.mark(marks);
  }

  /** Says what is wrong; without that, what stays so until the text is changed. */
  problem(text, lasting = this.lasting ?? '') {
    this.lasting = lasting;
    const told = inOwnWords(text) || lasting;
    byId('problem').hidden = told === '';
    byId('problem').textContent = plain(told);
  }

  state() {
    const state = { text: this.editor.text, tab: this.tab.name };
    for (const id of OPTIONS) {
      const control = byId(id);
      state[id] = control.type === 'checkbox' ? control.checked : control.value;
    }
    if (this.tab instanceof RunTab) Object.assign(state, { function: this.tab.function.select.value, args: this.tab.args.value, data: this.tab.data.value, inputs: JSON.stringify(this.tab.given) });
    return state;
  }

  /** Writes the state into the address, a while after the last change. A server's file is no state. */
  remember() {
    clearTimeout(this.remembering);
    if (this.file) return;
    this.remembering = setTimeout(async () => {
      const fragment = `#s=${await packed(this.state())}`;
      if (fragment !== window.location.hash) window.history.replaceState(null, '', fragment);
    }, 300);
  }

  /** Takes the state from the address. */
  async restore() {
    let state = null;
    try {
      state = await unpacked(window.location.hash);
    } catch (error) {
      this.problem('', `The link is damaged, and this is not its shader: ${error.message}`);
    }
    if (!state) return;
    this.setting = true;
    for (const id of OPTIONS) {
      const control = byId(id);
      if (control.type === 'checkbox') control.checked = state[id] === true;
      else if (typeof state[id] === 'string') control.value = state[id];
    }
    if (typeof state.text === 'string') this.editor.text = state.text;
    const run = this.tabs.find((tab) => tab instanceof RunTab);
    for (const id of ['args', 'data']) if (typeof state[id] === 'string') run[id].value = state[id];
    run.linked = pairs(state.inputs);
    run.wanted = state.function;
    run.written = typeof state.args === 'string';
    this.setting = false;
    this.choose(this.tabs.find(({ name }) => name === state.tab) ?? this.tab);
  }

  async copyLink() {
    const url = new URL(window.location.href);
    url.hash = `s=${await packed(this.state())}`;
    window.history.replaceState(null, '', url);
    copied(byId('link'), url.href);
  }

  /** Takes a shader that was dropped. */
  take(path, text) {
    const ending = path.split('.').at(-1);
    if ([...byId('kind').options].some(({ value }) => value === ending)) byId('kind').value = ending;
    this.editor.text = text;
  }

  /** Shows a file of the server. */
  open(file) {
    byId('file').title = file.path;
    byId('kind').disabled = true;
    this.setting = true;
    this.editor.text = file.text;
    this.setting = false;
    const lights = this.tabs.find((tab) => tab instanceof LightsTab);
    const isNew = lights.path !== file.path;
    // A scene that was saved from here is open already.
    if (file.scene !== null && (isNew || file.scene !== lights.given)) lights.open(file.path, file.scene, file.assets);
    if (file.scene !== null && isNew) this.choose(lights);
    else this.update();
    this.problem('', file.error ?? '');
  }

  /** Follows the server's files, without end: it answers when one has changed, or after a while. */
  async follow() {
    let version;
    for (;;) {
      const asked = performance.now();
      let isQuick = true;
      try {
        const found = await this.engine.files(version);
        isQuick = found.version === version && performance.now() - asked < PAUSE;
        if (found.version !== version) {
          const before = this.file;
          version = found.version;
          this.files = found.files;
          const select = byId('file');
          const chosen = select.value;
          select.replaceChildren(...this.files.map(({ path }) => el('option', { value: path }, path)));
          if (before) select.value = chosen;
          // A text that was edited here stays until its file changes.
          if (!before || JSON.stringify(before) !== JSON.stringify(this.file)) this.open(this.file);
        }
      } catch {
        this.problem('landfall serve has ended: start it again.');
      }
      if (isQuick) await new Promise((resolve) => { setTimeout(resolve, PAUSE); });
    }
  }
}

async function start() {
  const data = JSON.parse(byId('data').textContent);
  const engine = data.server ? new ServerEngine() : new LocalEngine();
  const page = new Playground(data, engine);
  if (data.server) byId('defines').value = data.server.defines.join(' ');
  try {
    await engine.begin();
  } catch (error) {
    page.problem(`WebAssembly does not start here: ${error.message}`);
    return;
  }
  if (data.server?.files.length > 0) {
    byId('file-label').hidden = false;
    page.follow();
  } else {
    await page.restore();
    page.update();
  }
}

start();
