// The page: the list of shaders and blocks, and the drawing of maps as they come into view.

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
