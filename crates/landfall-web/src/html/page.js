// The page: the findings, the list of shaders and blocks, and the drawing of maps as they come into
// view.

/** Findings that the overview lists at once. */
const MAX_LISTED = 50;

/** Numbers that order shaders, the largest first; of equal ones, and by path, the order is that of the page. */
const ORDERS = {
  findings: ({ findings }) => (findings.some((one) => levelOf(one) === 'error') ? 2 : Math.min(1, findings.length)),
  waste: ({ views }) => Math.max(0, ...views.map(({ own }) => own?.padding ?? 0)),
  size: ({ views }) => Math.max(0, ...views.map(({ own }) => own?.size ?? 0)),
  path: () => 0,
};

/** Which shaders are shown, by their findings. */
const SHOWN = {
  '': () => true,
  any: () => true,
  error: (finding) => levelOf(finding) === 'error',
  warning: (finding) => levelOf(finding) === 'warning',
};

/** A part of the page: the section of a shader with its views, and its entry in the list. */
class PagePart {
  constructor(shader, detail) {
    this.shader = shader;
    this.findings = shader.findings ?? [];
    this.id = nextId('shader-');
    this.views = [
      ...(shader.changes ?? []).map((change) => new ChangeView(change, shader, detail)),
      ...shader.blocks.map((block) => new BlockView(block, shader, detail)),
    ];
    this.element = this.section();
    this.entry = this.listed();
  }

  /** Whether there is nothing to see but its path. */
  get isBare() { return this.views.length === 0 && this.findings.length === 0; }

  section() {
    const { shader, findings, views, id } = this;
    const element = el('section', { class: 'shader', 'aria-labelledby': id },
      el('h2', { id, tabindex: '-1' }, el('span', {}, breakable(shader.path)), ' ', el('span', { class: 'note' }, [shader.language.toUpperCase(), shader.stage].filter(Boolean).join(' '))),
      shader.assumed ? el('p', { class: 'note' }, shader.assumed) : null);
    if (findings.length > 0) {
      this.details = el('details', { class: 'findings' }, el('summary', {}, badges(findings)));
      this.details.fill = () => {
        this.details.fill = null;
        this.items = findings.map(findingItem);
        this.details.append(el('ul', {}, this.items));
      };
      this.details.addEventListener('toggle', () => this.details.open && this.details.fill?.());
      if (findings.length <= 3) this.open();
      element.append(this.details);
    }
    this.tabs = Object.values(Object.groupBy(views, ({ block }, at) => (block?.variant ? `${block.space} ${block.name} ${block.instance}` : at)))
      .filter((all) => all.length > 1).map(variantTabs);
    for (const view of views) {
      const tabs = this.tabs.find((one) => one.views.includes(view));
      if (!tabs) element.append(view.element);
      else if (tabs.views[0] === view) element.append(tabs.bar, ...tabs.views.map((one) => one.element));
    }
    if (views.length === 0) element.append(el('p', { class: 'note' }, 'No blocks.'));
    const heights = views.reduce((sum, view) => sum + (view.height?.() ?? 400), 50);
    element.style.containIntrinsicSize = `auto ${heights}px`;
    return element;
  }

  /** Shows the findings. */
  open() {
    this.details.fill?.();
    this.details.open = true;
  }

  /** The entry in the list. */
  listed() {
    const target = (to, ...content) => el('a', { href: `#${to}` }, ...content);
    this.lines = this.views.map((view) => {
      const { own, change } = view;
      const size = (own?.size ?? null) === null ? 'no bytes' : bytes(own.size);
      const note = change ? change.class : size;
      const used = own && own.size > 0 ? 1 - own.padding / own.size : 1;
      const bar = el('span', { class: 'bar', 'aria-hidden': 'true' }, el('span', {}));
      bar.firstChild.style.width = `${Math.round(used * 100)}%`;
      const variant = view.block?.variant ? `${view.block.variant}, ` : '';
      const link = target(view.id, el('span', { class: 'name' }, view.title), ' ', el('span', { class: 'note' }, variant + note));
      link.addEventListener('click', () => view.select?.());
      return el('li', {}, link, own?.size > 0 ? bar : null);
    });
    return el('li', {}, target(this.id, el('span', { class: 'path' }, breakable(this.shader.path))), badges(this.findings), el('ul', {}, this.lines));
  }

  /** Shows what has a name, in lower case, and findings of a kind; returns whether anything is left. */
  filter(name, kind) {
    const has = (value) => value.toLowerCase().includes(name);
    const whole = has(this.shader.path);
    let some = whole || this.findings.some(({ code }) => has(code));
    this.views.forEach((view, at) => {
      const found = view.members?.some(([member]) => member.includes(name));
      const kept = whole || found || has(view.title);
      some ||= kept;
      hide(view.element, !kept);
      hide(this.lines[at], !kept);
      view.mark?.(found ? name : '');
    });
    for (const { bar, views } of this.tabs) {
      const left = views.filter((view) => !view.element.hidden);
      hide(bar, left.length === 0);
      if (left.every((view) => view.element.classList.contains('other'))) left[0]?.select();
    }
    some &&= kind === '' || this.findings.some(SHOWN[kind]);
    hide(this.element, !some);
    hide(this.entry, !some);
    return some;
  }
}

/** Switches between the blocks of one name that variants of a shader have. */
function variantTabs(views) {
  const bar = el('div', { class: 'tools rules variants', role: 'group', 'aria-label': `Variants of ${views[0].title}` });
  const show = (shown) => views.forEach((view, at) => {
    view.element.classList.toggle('other', view !== shown);
    bar.children[at].setAttribute('aria-pressed', String(view === shown));
  });
  for (const view of views) {
    view.select = () => show(view);
    bar.append(el('button', { type: 'button', on: { click: view.select } }, view.block.variant));
  }
  show(views[0]);
  return { bar, views };
}

/** The shaders, each with the blocks of its variants, which the page holds as shaders of their own. */
function withVariants(shaders) {
  const whole = [];
  for (const shader of shaders) {
    const { variant } = shader;
    const before = whole.at(-1);
    const blocks = variant ? shader.blocks.map((block) => ({ ...block, variant })) : shader.blocks;
    if (variant && before?.path === shader.path) before.blocks.push(...blocks);
    else whole.push({ ...shader, blocks: [...blocks] });
  }
  return whole;
}

/** Hides an element or shows it, without work where it is so already. */
function hide(element, hidden) {
  if (element.hidden !== hidden) element.hidden = hidden;
}

/** The findings of all shaders, and the way from one to the next. */
class Overview {
  constructor(element) {
    Object.assign(this, { element, at: -1 });
    document.addEventListener('keydown', (event) => {
      const typing = event.target.closest?.('input, textarea, select');
      if (typing || event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.key === 'n' || event.key === 'p') this.step(event.key === 'n' ? 1 : -1);
    });
  }

  /** Lists the findings of the parts that are shown. */
  show(parts, kind) {
    this.all = parts.flatMap((part) => (part.element.hidden ? [] : part.findings.map((finding, at) => ({ part, finding, at })))).filter(({ finding }) => SHOWN[kind](finding));
    this.at = -1;
    hide(this.element, this.all.length === 0);
    const line = (one, number) => el('li', {}, el('a', { href: `#${one.part.id}`, on: { click: (event) => {
      event.preventDefault();
      this.go(number);
    } } }, el('span', { class: `badge ${levelOf(one.finding)}` }, levelOf(one.finding)), ' ', el('code', {}, one.finding.code), ' ', prose(one.finding.message), ' ', el('span', { class: 'path' }, whereIs(one.finding))));
    const rest = this.all.slice(MAX_LISTED);
    const more = el('details', {}, el('summary', {}, `${counted(rest.length, 'more finding')}`));
    more.addEventListener('toggle', () => {
      if (more.childElementCount === 1) more.append(el('ol', { start: MAX_LISTED + 1 }, rest.map((one, at) => line(one, MAX_LISTED + at))));
    });
    this.told = el('span', { class: 'note', role: 'status' });
    const button = (label, key, step) => el('button', { type: 'button', 'aria-keyshortcuts': key, on: { click: () => this.step(step) } }, `${label} (${key})`);
    this.element.replaceChildren(
      el('div', { class: 'tools' }, el('h2', { id: 'findings', tabindex: '-1' }, counted(this.all.length, 'finding')),
        button('Previous', 'p', -1), button('Next', 'n', 1), this.told),
      el('ol', {}, this.all.slice(0, MAX_LISTED).map(line)), ...(rest.length > 0 ? [more] : []));
  }

  step(by) {
    if (this.all.length > 0) this.go((this.at + by + this.all.length + (this.at < 0 && by < 0 ? 1 : 0)) % this.all.length);
  }

  /** Goes to a finding. */
  go(number) {
    this.at = number;
    const { part, at } = this.all[number];
    part.open();
    part.items[at].focus({ preventScroll: true });
    part.items[at].scrollIntoView({ block: 'start' });
    this.told.textContent = `${number + 1} of ${this.all.length}`;
  }
}

/** The shaders without blocks and findings, in one line. */
function bareFold(parts) {
  const items = parts.map(({ shader }) => el('li', { class: 'path' }, breakable(shader.path)));
  const fold = el('details', { class: 'bare', hidden: parts.length === 0 }, el('summary', { id: 'bare' }, ''), el('ul', {}, items));
  const entry = el('li', { hidden: parts.length === 0 }, el('a', { href: '#bare' }, ''));
  fold.filter = (name, kind) => {
    const kept = parts.map(({ shader }) => kind === '' && shader.path.toLowerCase().includes(name));
    items.forEach((item, at) => hide(item, !kept[at]));
    const count = kept.filter(Boolean).length;
    const told = `${counted(count, 'file')} without blocks and findings`;
    fold.firstChild.textContent = told;
    entry.firstChild.textContent = told;
    [fold, entry].forEach((one) => hide(one, count === 0));
    return count > 0;
  };
  return { fold, entry };
}

/** The block with the most padding, as a link to it. */
function mostPadding(views) {
  const [most] = views.filter(({ own }) => own?.padding > 0).sort((a, b) => b.own.padding - a.own.padding);
  return most && ['most padding: ', el('a', { href: `#${most.id}`, on: { click: () => most.select?.() } }, most.title), `, ${bytes(most.own.padding)}`];
}

/** What the line below the title says. */
function summary(parts, version) {
  const views = parts.flatMap((part) => part.views);
  const changes = views.filter((view) => view.change).length;
  const findings = parts.flatMap((part) => part.findings);
  const facts = [
    counted(parts.length, 'shader'), views.length > changes && counted(views.length - changes, 'block'),
    changes > 0 && counted(changes, 'changed block'), findings.length === 0 ? 'no findings' : el('a', { href: '#findings' }, badges(findings)),
    mostPadding(views), `landfall ${version}`,
  ].filter(Boolean);
  return facts.flatMap((fact, at) => (at > 0 ? [' · ', fact] : [fact])).flat();
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
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId('data').textContent);
  TEXTS.push(...data.texts);
  document.title = data.title;
  byId('title').textContent = data.title;
  const detail = new Detail(byId('detail'));
  const all = withVariants(data.shaders).map((shader) => new PagePart(shader, detail));
  const parts = all.filter((part) => !part.isBare);
  const bare = bareFold(all.filter((part) => part.isBare));
  const overview = new Overview(byId('overview'));
  byId('summary').replaceChildren(...summary(all, data.tool.version));
  const [search, order, shown] = ['filter', 'order', 'shown'].map(byId);
  const arranged = () => {
    const number = ORDERS[order.value];
    const keyed = parts.map((part, at) => [number(part), at, part]).sort(([a, i], [b, j]) => b - a || i - j);
    return keyed.map(([, , part]) => part);
  };
  let now = parts;
  const filter = () => {
    const name = search.value.trim().toLowerCase();
    const kept = now.filter((part) => part.filter(name, shown.value)).length;
    byId('none').hidden = bare.fold.filter(name, shown.value) || kept > 0;
    overview.show(now, shown.value);
  };
  const arrange = () => {
    now = arranged();
    byId('list').replaceChildren(...now.map((part) => part.entry), bare.entry);
    byId('shaders').replaceChildren(...now.map((part) => part.element), bare.fold);
    filter();
  };
  hide(byId('kinds'), all.every((part) => part.findings.length === 0));
  arrange();
  search.addEventListener('input', filter);
  order.addEventListener('change', arrange);
  shown.addEventListener('change', filter);
  const seen = new IntersectionObserver((found) => found.filter((one) => one.isIntersecting).forEach(({ target }) => {
    seen.unobserve(target);
    if (!target.view.drawn) target.view.draw();
  }), { rootMargin: '400px' });
  parts.flatMap((part) => part.views).forEach((view) => seen.observe(view.element));
  window.addEventListener('beforeprint', () => drawAll(parts));
  // On a narrow screen the list would come before every map.
  byId('contents').open = !window.matchMedia('(max-width: 720px)').matches;
  dropping();
  const opened = all.flatMap((part) => part.views).find((view) => view.block?.name === data.at);
  if (opened) {
    byId(opened.id).focus({ preventScroll: true });
    byId(opened.id).scrollIntoView({ block: 'start' });
  }
  document.documentElement.dataset.ready = String(Math.round(performance.now() - began));
}

start();
