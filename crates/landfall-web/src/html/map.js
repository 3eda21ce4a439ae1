// The memory map of a block under one set of rules: rows of 16 bytes, a cell for each scalar,
// vector and column, frames for structures and arrays, hatching for padding.

/** Elements shown of an array that has more: the first two and the last. */
const FEW = 4;
/** Elements that a fold opens at a time. */
const OPENED = 8;
/** Cells of a map; the byte field reaches the rest. */
const MAX_CELLS = 4000;
const COLOURS = 8;

/**
 * A map. `view` holds the block's bytes, if any; `state` has what several maps of a block share:
 * `colours` by pattern, and `opened` elements by the path of their array. `mark` says what a cell
 * has become on the other side of a difference.
 */
function memoryMap(layout, { view = null, state, label, select, changed, mark = () => null }) {
  const root = el('div', { class: 'map', role: 'group', 'aria-label': label });
  const context = { layout, view, state, select, mark, changed, items: [], cells: 0 };
  root.append(el('div', { class: 'row ticks', 'aria-hidden': 'true' }, el('span', { class: 'at' }),
    el('div', { class: 'bytes' }, [0, 4, 8, 12].map((n) => el('span', {}, `+${n}`)))));
  const place = blockPlace(layout, view?.byteLength);
  fill(root, place, context);
  if (context.cells >= MAX_CELLS) {
    root.append(el('p', { class: 'note' }, `Only the first ${counted(MAX_CELLS, 'cell')} are drawn; the byte field finds the others.`));
  }
  if (!root.querySelector('.cell')) root.append(el('p', { class: 'note' }, 'No bytes.'));
  rove(root);
  root.items = context.items;
  return root;
}

/** Adds the rows and frames of a place to its container. */
function fill(container, place, context) {
  let run = [];
  const flush = () => {
    if (run.length > 0) rows(container, place, run, context);
    run = [];
  };
  const add = (part) => {
    if (context.cells >= MAX_CELLS) return;
    if (part.kind === 'leaf') partsOfLeaf(part).forEach(add);
    else if (part.kind === 'vector' || part.kind === 'padding') {
      run.push(part);
      context.cells += 1;
    } else {
      flush();
      container.append(frame(part, context));
    }
  };
  if (place.kind === 'struct') partsOfStruct(place).forEach(add);
  else {
    let next = 0;
    for (const index of shownElements(place, context)) {
      if (index > next) {
        flush();
        container.append(fold(place, next, index, context));
      }
      partsOfElement(place, index).forEach(add);
      next = index + 1;
    }
    if (next < place.count || place.endless) {
      flush();
      container.append(fold(place, next, place.count, context));
    }
  }
  flush();
}

/** The indices of the elements that are drawn, in order. */
function shownElements(array, { state }) {
  const all = array.count <= FEW ? Array.from({ length: array.count }, (_, index) => index) : [0, 1, array.count - 1];
  const opened = state.opened.get(array.path) ?? [];
  const inside = [...opened].filter((index) => index < array.count);
  return [...new Set([...all, ...inside])].sort((a, b) => a - b);
}

/** A frame around a structure or an array. */
function frame(place, context) {
  const type = typeOf(place);
  const facts = [`${place.start}–${Math.max(place.start, place.end - 1)}`];
  if (place.kind === 'array') facts.push(`stride ${place.stride}`);
  if (place.endless) facts[0] = `from ${place.start}`;
  const head = el('button', { type: 'button', class: 'head', tabindex: '-1', 'aria-label': spoken(place, type) },
    el('b', {}, last(place)), ' ', el('span', { class: 'type' }, type), ' ', el('span', { class: 'facts' }, facts.join(' · ')));
  head.place = place;
  context.items.push({ place, type, note: facts.slice(1).join(', ') });
  const box = el('div', { class: `frame ${place.kind}` }, head);
  fill(box, place, context);
  return box;
}

/** The elements of an array that are not drawn, as a button that draws some of them. */
function fold(array, from, to, context) {
  const { stride, start, path } = array;
  const count = to - from;
  const range = `${start + from * stride} to ${start + to * stride - 1}`;
  const what = count > 0 ? `${counted(count, 'more element')}, ${stride} bytes each: bytes ${range}`
    : `and so on to the end of the buffer, every ${stride} bytes`;
  context.items.push({ fold: what, path });
  if (count <= 0) return el('p', { class: 'fold' }, `⋮ ${what}`);
  const open = () => {
    const opened = context.state.opened.get(path) ?? new Set();
    for (let index = from; index < Math.min(to, from + OPENED); index += 1) opened.add(index);
    context.state.opened.set(path, opened);
    context.changed(start + from * stride);
  };
  return el('button', { type: 'button', class: 'fold', tabindex: '-1', on: { click: open } }, `⋮ ${what}`);
}

/** The rows of contiguous parts. */
function rows(container, frameOf, parts, context) {
  let row = null;
  let at = null;
  for (const part of parts) {
    if (part.end === part.start) continue;
    const first = Math.floor(part.start / ROW);
    const cellAt = part.kind === 'padding' ? paddingCell(part, context) : vectorCell(part, frameOf, context);
    for (let number = first; number * ROW < part.end; number += 1) {
      if (number !== at) {
        at = number;
        row = el('div', { class: 'bytes' });
        container.append(el('div', { class: 'row' }, el('span', { class: 'at', 'aria-hidden': 'true' },
          String(number * ROW), el('i', {}, hex(number * ROW))), row));
      }
      const from = Math.max(part.start - number * ROW, 0);
      const to = Math.min(part.end - number * ROW, ROW);
      // What a cell continues in the next row is seen, but is not another cell.
      const cell = number === first ? cellAt : el('div', { class: `${cellAt.className} more`, 'aria-hidden': 'true' }, '⤷');
      cell.style.gridColumn = `${from + 1} / ${to + 1}`;
      cell.classList.toggle('narrow', to - from < 4);
      cell.classList.toggle('word', to - from <= 4);
      cell.place = part;
      row.append(cell);
    }
  }
}

function vectorCell(place, frameOf, context) {
  const type = typeOf(place);
  const values = context.view ? components(context.view, place) : [];
  const mark = context.mark(place);
  const odd = values.some((value) => value.odd);
  const cell = el('button', {
    type: 'button', tabindex: '-1', 'aria-label': spoken(place, type, values, mark?.text),
    class: `cell c${colour(place, context)}${odd ? ' odd' : ''}${mark ? ` ${mark.class}` : ''}`,
    data: { path: place.path, offset: place.start, size: place.end - place.start, type },
  },
  el('b', {}, place.byRow ? `${last(place, frameOf)} ${type}` : last(place, frameOf)),
  el('span', { class: 'type' }, place.byRow ? null : el('span', {}, type), el('i', {}, String(place.start))),
  mark ? el('span', { class: 'mark' }, mark.short) : null,
  values.length === 0 ? null : el('span', { class: 'values' }, values.map((value) => (
    el('span', { class: value.odd ? 'bad' : '' }, value.odd ? `⚠ ${value.text}` : value.text)
  ))));
  const value = values.map(told).join(', ');
  context.items.push({ place, type, value, note: mark?.text ?? '' });
  return cell;
}

function paddingCell(place, context) {
  const size = place.end - place.start;
  const strays = context.view ? strayBytes(context.view, place) : '';
  const what = paddingText(place);
  const cell = el('button', {
    type: 'button', tabindex: '-1', class: `cell pad ${place.padding === 'hole' ? 'hole' : 'tail'}${strays ? ' odd' : ''}`,
    'aria-label': `${place.padding}, ${what}, bytes ${place.start} to ${place.end - 1}${strays && `, not zero: ${strays}`}`,
    data: { path: '', offset: place.start, size, padding: place.padding },
  }, el('span', { class: 'type' }, strays ? `⚠ ${strays}` : `${size} B`));
  context.items.push({ place, type: place.padding, note: what, value: strays && `not zero: ${strays}` });
  return cell;
}

/** The bytes of padding in hexadecimal, if any is not zero. */
function strayBytes(view, { start, end }) {
  const all = [];
  for (let at = start; at < Math.min(end, view.byteLength); at += 1) all.push(view.getUint8(at));
  return all.some((byte) => byte !== 0) ? all.map((byte) => byte.toString(16).padStart(2, '0')).join(' ') : '';
}

/** A value, and why it is suspicious. */
const told = ({ text: shown, odd }) => (odd && odd !== shown ? `${shown} (${odd})` : shown);

/** What a screen reader says of a cell. */
function spoken(place, type, values = [], mark = '') {
  const parts = [place.path, type, `bytes ${place.start} to ${place.end - 1}`];
  if (values.length > 0) parts.push(values.map(told).join(' '));
  if (mark) parts.push(mark);
  return parts.join(', ');
}

/** The end of a path, from the frame that a cell is in. */
function last(place, frameOf = place.parent) {
  const { path } = place;
  const from = frameOf?.path ?? '';
  const rest = path.startsWith(from) ? path.slice(from.length) : path;
  return rest.replace(/^\./, '') || path;
}

/** What members of one colour share: their pattern, without the column of a matrix. */
const colourKey = (place) => pattern(place.vector === null ? place.path : place.parent.path);

/** The colour of a member: the same under all rules and on both sides of a difference. */
function colour(place, { state }) {
  const key = colourKey(place);
  if (!state.colours.has(key)) state.colours.set(key, state.colours.size % COLOURS);
  return state.colours.get(key);
}

/** One cell of a map takes the tab key; arrows move between cells. */
function rove(map) {
  const stops = () => [...map.querySelectorAll('button')];
  const [first] = stops();
  if (first) first.tabIndex = 0;
  const focus = (stop) => {
    if (!stop) return;
    stops().forEach((one) => { one.tabIndex = -1; });
    stop.tabIndex = 0;
    stop.focus();
  };
  map.addEventListener('focusin', ({ target }) => {
    if (target.tabIndex === 0 || target.tagName !== 'BUTTON') return;
    stops().forEach((one) => { one.tabIndex = one === target ? 0 : -1; });
  });
  map.addEventListener('keydown', (event) => {
    const all = stops();
    const at = all.indexOf(document.activeElement);
    if (at < 0 || event.ctrlKey || event.altKey || event.metaKey) return;
    const moves = {
      ArrowRight: () => all[at + 1], ArrowLeft: () => all[at - 1], Home: () => all[0], End: () => all.at(-1),
      ArrowDown: () => beside(all, at, 1), ArrowUp: () => beside(all, at, -1),
    };
    if (!moves[event.key]) return;
    event.preventDefault();
    focus(moves[event.key]());
  });
}

/** The nearest stop in the next line, up or down. */
function beside(all, at, direction) {
  const from = all[at].getBoundingClientRect();
  let line = null;
  let best = null;
  for (let index = at + direction; index >= 0 && index < all.length; index += direction) {
    const box = all[index].getBoundingClientRect();
    if (Math.abs(box.top - from.top) < 2) continue;
    line ??= box.top;
    if (Math.abs(box.top - line) > 2) break;
    const distance = Math.abs(box.left - from.left);
    if (!best || distance < best.distance) best = { stop: all[index], distance };
  }
  return best?.stop;
}

/** The map as a table: each cell, frame and fold in a row. */
function mapTable(items, caption, withValues) {
  const line = ({ place, type, note = '', value = '', fold: folded, path }) => {
    if (folded) return [`${path}[…]`, '', '', '', '', '', ...(withValues ? [''] : []), folded];
    const named = place.kind === 'padding' ? place.path || '(block)' : place.path;
    const end = place.endless ? '' : String(place.end - place.start);
    const shown = [named, type, String(place.start), hex(place.start), end, String(place.member?.align ?? '')];
    return [...shown, ...(withValues ? [value] : []), note];
  };
  const columns = ['Path', 'Type', 'Offset', 'Hex', 'Size', 'Align', ...(withValues ? ['Value'] : []), 'Note'];
  return table(caption, columns, items.map(line));
}
