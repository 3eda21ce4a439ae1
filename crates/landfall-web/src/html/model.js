// The places of a block: members, elements, columns and the padding between them, computed from
// the numbers of the page. Nothing here touches the document.

/** Bytes of a row of the map. */
const ROW = 16;
const COMPONENTS = ['x', 'y', 'z', 'w'];
const TEXTS = [];

const text = (index) => TEXTS[index];
const texts = (indices) => indices.map(text);

/** Bytes from a member's start to its end; a runtime-sized one counts as one element. */
const reach = (member) => member.size ?? member.strides?.[0] ?? 0;
const hasDims = (member) => member.dims !== undefined && member.dims.length > 0;
const isEndless = (member) => hasDims(member) && member.dims[0] === null;

/**
 * The place of a whole block. `length` is the number of bytes at hand, which decides how many
 * elements a runtime-sized array has; without it there is one.
 */
function blockPlace(layout, length) {
  const end = Math.max(layout.size ?? 0, length ?? 0);
  return {
    kind: 'struct', owner: 'block', path: '', start: 0, end, whole: layout.size ?? 0,
    members: layout.members, length, parent: null, step: null,
  };
}

/** The place of a member of a block or structure. */
function memberPlace(parent, member) {
  const start = parent.start + member.offset;
  const path = parent.path === '' ? member.name : `${parent.path}.${member.name}`;
  const step = {
    type: member.type, base: parent.start, adds: member.offset,
    rule: texts(member.why.rule), lines: texts(member.why.lines),
  };
  const size = member.own_size ?? member.size;
  const place = typed(member, 0, start, path, parent, step);
  if (size !== null) place.end = start + size;
  else place.end = start + place.count * place.stride;
  return place;
}

/** A place within a member, below its first `dim` dimensions. */
function typed(member, dim, start, path, parent, step) {
  const place = { member, dim, start, path, parent, step, end: start + member.element };
  if (hasDims(member) && dim < member.dims.length) {
    const stride = member.strides[dim];
    let count = member.dims[dim];
    if (count === null) {
      const length = root(place).length;
      count = length === undefined ? 1 : Math.max(0, Math.floor((length - start) / stride));
    }
    Object.assign(place, { kind: 'array', count, stride, end: start + count * stride });
    place.endless = member.dims[dim] === null;
  } else if (member.leaf === undefined) {
    Object.assign(place, { kind: 'struct', owner: 'structure', members: member.members });
  } else {
    place.kind = 'leaf';
  }
  return place;
}

function root(place) {
  let at = place;
  while (at.parent) at = at.parent;
  return at;
}

/** An element of an array, which may be an array itself. */
function elementPlace(array, index) {
  const { member, dim, stride } = array;
  const start = array.start + index * stride;
  const why = member.why_elements[dim];
  const step = {
    type: member.below[dim], base: array.start, adds: index * stride,
    rule: texts(why.rule),
    lines: [...texts(why.lines), `${index} × ${stride} = ${index * stride}`],
  };
  return typed(member, dim + 1, start, `${array.path}[${index}]`, array, step);
}

/** The unused bytes between and after the members of a block or structure, by offset. */
function gaps(place) {
  const order = [...place.members].sort((a, b) => a.offset - b.offset);
  const found = [];
  let end = 0;
  let after = null;
  const whole = place.owner === 'block' ? place.whole : place.end - place.start;
  const push = (kind, to, before) => found.push({
    kind: 'padding', padding: kind, owner: place.owner, path: place.path, place,
    start: place.start + end, end: place.start + to, after, before,
  });
  for (const member of order) {
    if (member.offset > end) push('hole', member.offset, member.name);
    if (member.offset + reach(member) >= end) {
      end = member.offset + reach(member);
      after = member.name;
    }
  }
  // What follows a runtime-sized array are its further elements.
  if (whole > end && !place.members.some(isEndless)) push('tail padding', whole, null);
  return found;
}

const tail = (owner, place, path, start, end) => ({
  kind: 'padding', padding: 'tail padding', owner, path, place, start, end, after: null, before: null,
});

/** What a block or structure consists of, by offset: its members and its padding. */
function partsOfStruct(place) {
  const parts = place.members.map((member) => memberPlace(place, member));
  for (const part of [...parts]) {
    const end = part.start + reach(part.member);
    if (part.member.own_size !== undefined) parts.push(tail('member', part, part.path, part.end, end));
  }
  return [...parts, ...gaps(place)].sort((a, b) => a.start - b.start);
}

/** An element of an array and the padding up to the next one. */
function partsOfElement(array, index) {
  const element = elementPlace(array, index);
  const after = array.start + (index + 1) * array.stride;
  const next = array.endless ? after : Math.min(after, array.end);
  const pad = element.kind !== 'array' && element.end < next;
  return pad ? [element, tail('element', element, element.path, element.end, next)] : [element];
}

/** The columns of a matrix as places; rows, if it is stored by rows; a vector or scalar as one. */
function partsOfLeaf(place) {
  const { member, start } = place;
  const { leaf } = member;
  if (leaf.columns === 1) return [{ ...place, kind: 'vector', type: typeOf(place), vector: null }];
  const byRow = member.row_major === true;
  const [count, length] = byRow ? [leaf.rows, leaf.columns] : [leaf.columns, leaf.rows];
  const stride = member.matrix_stride;
  const parts = [];
  for (let index = 0; index < count; index += 1) {
    const from = start + index * stride;
    const path = byRow ? place.path : `${place.path}[${index}]`;
    const to = from + length * leaf.width;
    const step = byRow ? null : {
      type: leaf.column, base: start, adds: index * stride, rule: [],
      lines: [text(member.why_columns), `${index} × ${stride} = ${index * stride}`],
    };
    parts.push({
      kind: 'vector', member, path, start: from, end: to, parent: place, step, vector: index,
      byRow, type: byRow ? `row ${index}` : leaf.column,
    });
    const owner = byRow ? 'row' : 'column';
    if (length * leaf.width < stride) parts.push(tail(owner, place, path, to, from + stride));
  }
  return parts;
}

/** The type of a place in the shader's spelling. */
const typeOf = (place) => place.type ?? place.step?.type ?? place.member?.type ?? '';

/** The steps from the block to a place, as `landfall explain` prints them. */
function chain(place) {
  const steps = [];
  for (let at = place; at; at = at.parent) {
    if (at.step) steps.unshift({ path: at.path, ...at.step });
  }
  return steps;
}

/** The path with its indices left open: `data[].pos`. */
const pattern = (path) => path.replace(/\[\d+\]/g, '[]');

/** The component or padding that a byte belongs to; `beyond` past the end. */
function ownerOf(layout, byte, length) {
  let place = blockPlace(layout, length);
  for (;;) {
    let parts;
    if (place.kind === 'array') {
      const index = Math.floor((byte - place.start) / place.stride);
      parts = partsOfElement(place, index);
    } else if (place.kind === 'struct') {
      // In the order of the text: of members that overlap, the first one has the byte.
      const member = place.members.find((one) => {
        const from = place.start + one.offset;
        return byte >= from && (isEndless(one) || byte < from + reach(one));
      });
      if (member) {
        const found = memberPlace(place, member);
        const inside = isEndless(member) || byte < found.end;
        const end = found.start + reach(member);
        parts = [inside ? found : tail('member', found, found.path, found.end, end)];
      } else parts = gaps(place);
    } else if (place.kind === 'leaf') {
      parts = partsOfLeaf(place);
    } else return place.kind === 'padding' ? place : componentOf(place, byte);
    const endless = place.kind === 'struct' && parts.length === 1 && parts[0].endless;
    const next = endless ? parts[0] : parts.find((part) => byte >= part.start && byte < part.end);
    if (!next) return { kind: 'beyond', size: layout.size };
    place = next;
  }
}

/** The component of a vector place that a byte belongs to. */
function componentOf(place, byte) {
  const { leaf } = place.member;
  const nth = Math.floor((byte - place.start) / leaf.width);
  const start = place.start + nth * leaf.width;
  let path = place.path;
  if (place.byRow) path = `${place.path}[${nth}].${COMPONENTS[place.vector]}`;
  else if (leaf.rows > 1) path = `${place.path}.${COMPONENTS[nth]}`;
  const whole = place.vector === null ? place : place.parent;
  return {
    kind: 'component', path, start, end: start + leaf.width, byte: byte - start, place,
    leaf: whole.path, type: whole.step?.type ?? place.member.type,
    leafStart: whole.start, leafEnd: whole.start + place.member.element,
  };
}

/** What `landfall explain @BYTE` answers, in one sentence. */
function whoIsAt(layout, byte, length) {
  const found = ownerOf(layout, byte, length);
  if (found.kind === 'beyond') return `byte ${byte} lies past the end: the block has ${bytes(found.size)}`;
  if (found.kind === 'component') {
    const { path, type, leaf, leafStart, leafEnd, start, end } = found;
    return `byte ${byte} is byte ${found.byte} of ${end - start} of ${path} `
      + `(${type} \`${leaf}\`, bytes ${leafStart} to ${leafEnd - 1})`;
  }
  return `byte ${byte} is padding: ${paddingText(found)} (bytes ${found.start} to ${found.end - 1})`;
}

/** The owner of padding and its neighbours. */
function paddingText({ padding, owner, path, after, before }) {
  const of = path === '' ? `the ${owner}` : `${owner} ${path}`;
  const behind = after === null ? '' : `, after \`${after}\``;
  const ahead = before === null ? '' : `, before \`${before}\``;
  return `${padding === 'hole' ? 'a hole in' : 'tail padding of'} ${of}${behind}${ahead}`;
}

const bytes = (n) => (n === 1 ? '1 byte' : `${n.toLocaleString('en')} bytes`);
const hex = (n) => `0x${n.toString(16)}`;
const counted = (n, noun) => `${n.toLocaleString('en')} ${noun}${n === 1 ? '' : 's'}`;
