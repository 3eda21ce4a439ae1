// The page: the list of shaders and blocks, the panel of the selected bytes, and the drawing of maps
// as they come into view.

/** The panel that says what is under the pointer or has the focus. */
class Detail {
  constructor(element) {
    this.element = element;
    element.classList.add('empty');
    element.append(el('h2', {}, 'Bytes'), el('p', {}, 'Point at a cell, or move to it with the arrow keys: '
      + 'here is its path, its offset and the rules that put it there.'));
  }

  show(place, layout, shader, view) {
    if (this.place === place && this.view === view) return;
    Object.assign(this, { place, view });
    this.element.classList.remove('empty');
    const padding = place.kind === 'padding';
    const size = place.end - place.start;
    const facts = [
      ['Offset', `${place.start} (${hex(place.start)})`],
      ['Bytes', size > 0 ? `${place.start} to ${place.end - 1}, ${bytes(size)}` : 'none'],
      ['Type', padding ? null : typeOf(place)],
      ['Align', padding || place.vector !== null && place.vector !== undefined ? null : place.member.align],
      ['Rules', RULE_NAMES[layout.rules]],
      ['Declared', place.member?.line > 0 ? `${shader.path}:${place.member.line}` : null],
    ];
    if (view && place.kind === 'vector') {
      const values = components(view, place);
      facts.push(['Value', values.map(told).join(', ')]);
    }
    const list = el('dl', {}, facts.filter(([, value]) => value !== null && value !== '')
      .map(([name, value]) => [el('dt', {}, name), el('dd', {}, String(value))]));
    const title = padding ? place.padding : place.path;
    this.element.replaceChildren(el('h2', {}, padding ? title : el('code', {}, title)), list);
    if (padding) this.element.append(el('p', {}, prose(paddingText(place))));
    else this.element.append(el('h3', {}, 'Why here'), el('ol', { class: 'chain' }, chain(place).map(step)));
  }
}

/** A step of the chain of rules. */
function step({ path, type, rule, lines, base, adds }) {
  return el('li', {}, el('p', {}, el('code', {}, path), ' ', el('span', { class: 'type' }, type)),
    rule.map((line) => el('p', { class: 'rule' }, line)), lines.map((line) => el('p', {}, prose(line))),
    el('p', { class: 'sum' }, `${base} + ${adds} = ${base + adds}`));
}

/** A finding with its notes, listing and help. */
function findingItem(finding) {
  const { place } = finding;
  const where = place.line > 0 ? `${place.path}:${place.line}:${place.column}` : place.path;
  const level = finding.level === 'deny' ? 'error' : 'warning';
  return el('li', { class: 'finding' },
    el('p', {}, el('span', { class: `badge ${level}` }, level), ' ', el('code', {}, finding.code), ' ', prose(finding.message)),
    el('p', { class: 'note' }, where, finding.text ? [': ', prose(finding.text)] : ''),
    finding.related.map((label) => el('p', { class: 'note' }, `${label.place.path}:${label.place.line}`, label.text ? [': ', prose(label.text)] : '')),
    finding.notes.map((note) => el('p', { class: 'note' }, prose(note))),
    finding.listing ? el('pre', { tabindex: '0' }, finding.listing) : null,
    finding.help ? el('p', {}, el('b', {}, 'help: '), prose(finding.help)) : null);
}

/** The section of a shader, with its views. */
function section(shader, detail) {
  const id = nextId('shader-');
  const views = [
    ...(shader.changes ?? []).map((change) => new ChangeView(change, shader, detail)),
    ...shader.blocks.map((block) => new BlockView(block, shader, detail)),
  ];
  const findings = shader.findings ?? [];
  const element = el('section', { class: 'shader', 'aria-labelledby': id },
    el('h2', { id, tabindex: '-1' }, shader.path, ' ', el('span', { class: 'note' }, [shader.language.toUpperCase(), shader.stage].filter(Boolean).join(' '))),
    shader.assumed ? el('p', { class: 'note' }, shader.assumed) : null);
  if (findings.length > 0) {
    const details = el('details', { class: 'findings' }, el('summary', {}, counted(findings.length, 'finding')));
    details.fill = () => {
      details.fill = null;
      details.append(el('ul', {}, findings.map(findingItem)));
    };
    details.addEventListener('toggle', () => details.open && details.fill?.());
    if (findings.length <= 3) {
      details.fill();
      details.open = true;
    }
    element.append(details);
  }
  element.append(...views.map((view) => view.element));
  if (views.length === 0) element.append(el('p', { class: 'note' }, 'No blocks.'));
  return { id, element, views, shader, findings };
}

/** The entry of a shader in the list. */
function entry({ id, views, shader, findings }) {
  const target = (to, ...content) => el('a', { href: `#${to}` }, ...content);
  const items = views.map((view) => {
    const { own, change } = view;
    const size = (own?.size ?? null) === null ? 'no bytes' : bytes(own.size);
    const note = change ? change.class : size;
    const used = own && own.size > 0 ? 1 - own.padding / own.size : 1;
    const bar = el('span', { class: 'bar', 'aria-hidden': 'true' }, el('span', {}));
    bar.firstChild.style.width = `${Math.round(used * 100)}%`;
    return el('li', {}, target(view.id, el('span', { class: 'name' }, view.title), ' ', el('span', { class: 'note' }, note)), own?.size > 0 ? bar : null);
  });
  const count = findings.length > 0 ? el('span', { class: 'badge warning' }, counted(findings.length, 'finding')) : null;
  return el('li', {}, target(id, el('span', { class: 'path' }, shader.path)), ' ', count, el('ul', {}, items));
}

/** Hides the entries and sections whose shader and blocks do not have the name. */
function filter(parts, entries, wanted) {
  const name = wanted.trim().toLowerCase();
  const has = (value) => value.toLowerCase().includes(name);
  let any = false;
  parts.forEach((part, index) => {
    const whole = has(part.shader.path);
    let some = whole;
    part.views.forEach((view, at) => {
      const kept = whole || has(view.title);
      some ||= kept;
      view.element.hidden = !kept;
      entries[index].querySelectorAll('ul > li')[at].hidden = !kept;
    });
    part.element.hidden = !some;
    entries[index].hidden = !some;
    any ||= some;
  });
  document.getElementById('none').hidden = any;
}

/** Draws every map and fills every table, for printing. */
function drawAll(parts) {
  parts.flatMap((part) => part.views).filter((view) => !view.drawn).forEach((view) => view.draw());
  document.querySelectorAll('details').forEach((details) => {
    details.fill?.();
    details.open = true;
  });
}

/** A file dropped on a block is its bytes; anywhere else it is ignored, not opened. */
function dropping() {
  const over = (target) => target.closest?.('article.block')?.view;
  document.addEventListener('dragover', (event) => event.preventDefault());
  document.addEventListener('drop', (event) => {
    event.preventDefault();
    const view = over(event.target);
    if (view?.read && event.dataTransfer.files.length > 0) view.read(event.dataTransfer.files[0]);
  });
}

function start() {
  const began = performance.now();
  const data = JSON.parse(document.getElementById('data').textContent);
  TEXTS.push(...data.texts);
  document.title = data.title;
  document.getElementById('title').textContent = data.title;
  const detail = new Detail(document.getElementById('detail'));
  const parts = data.shaders.map((shader) => section(shader, detail));
  const entries = parts.map(entry);
  document.getElementById('list').append(...entries);
  document.getElementById('main').replaceChildren(...parts.map((part) => part.element));
  const views = parts.flatMap((part) => part.views);
  const changes = views.filter((view) => view.change).length;
  const findings = parts.reduce((sum, part) => sum + part.findings.length, 0);
  const facts = [
    counted(parts.length, 'shader'), views.length > changes && counted(views.length - changes, 'block'),
    changes > 0 && counted(changes, 'changed block'), counted(findings, 'finding'), `landfall ${data.tool.version}`,
  ];
  document.getElementById('summary').textContent = facts.filter(Boolean).join(' · ');
  const search = document.getElementById('filter');
  search.addEventListener('input', () => filter(parts, entries, search.value));
  const seen = new IntersectionObserver((all) => all.filter((one) => one.isIntersecting).forEach(({ target }) => {
    seen.unobserve(target);
    if (!target.view.drawn) target.view.draw();
  }), { rootMargin: '400px' });
  views.forEach((view) => seen.observe(view.element));
  window.addEventListener('beforeprint', () => drawAll(parts));
  // On a narrow screen the list would come before every map.
  document.getElementById('contents').open = !window.matchMedia('(max-width: 720px)').matches;
  dropping();
  document.documentElement.dataset.ready = String(Math.round(performance.now() - began));
}

start();
