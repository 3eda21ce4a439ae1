// Reads the bytes of a block as `landfall decode` does: little-endian components, and the bytes
// that are suspicious.

/** The most suspicious places that are kept; further ones are counted. */
const MAX_ODD = 1000;

/** The value of a component. */
function component(view, at, { kind, width }) {
  if (kind === 'float' && width === 4) return view.getFloat32(at, true);
  if (kind === 'float' && width === 8) return view.getFloat64(at, true);
  if (width === 8) return kind === 'sint' ? view.getBigInt64(at, true) : view.getBigUint64(at, true);
  const bits = unsigned(view, at, width);
  switch (kind) {
    case 'float': return small(bits, 5, 10, true);
    case 'bfloat': {
      const word = new DataView(new ArrayBuffer(4));
      word.setUint32(0, bits * 65536);
      return word.getFloat32(0);
    }
    case 'float_e5m2': return small(bits, 5, 2, true);
    case 'float_e4m3': return small(bits, 4, 3, false);
    case 'sint': return (bits << (32 - 8 * width)) >> (32 - 8 * width);
    case 'bool': return bits > 1 ? bits : bits === 1;
    default: return bits;
  }
}

function unsigned(view, at, width) {
  if (width === 4) return view.getUint32(at, true);
  return width === 2 ? view.getUint16(at, true) : view.getUint8(at);
}

/** A float of less than 32 bits; E4M3 has no infinity, and its NaN are all ones. */
function small(bits, exponents, fractions, infinite) {
  const fraction = bits % 2 ** fractions;
  const exponent = (bits >> fractions) % 2 ** exponents;
  const sign = bits >> (exponents + fractions) ? -1 : 1;
  const bias = 2 ** (exponents - 1) - 1;
  const last = 2 ** exponents - 1;
  if (exponent === last && infinite) return fraction === 0 ? sign * Infinity : NaN;
  if (exponent === last && fraction === 2 ** fractions - 1) return NaN;
  const scale = fraction / 2 ** fractions;
  return exponent === 0
    ? sign * scale * 2 ** (1 - bias)
    : sign * (1 + scale) * 2 ** (exponent - bias);
}

/** The shortest text that reads back as the same value. */
function valueText(value, { kind, width }) {
  if (typeof value !== 'number' || kind !== 'float' || width !== 4) {
    return Object.is(value, -0) ? '-0' : String(value);
  }
  if (Object.is(value, -0)) return '-0';
  for (let digits = 1; digits <= 9; digits += 1) {
    const short = Number(value.toPrecision(digits));
    if (Math.fround(short) === value) return String(short);
  }
  return String(value);
}

/** Why a value is suspicious; `null` for one that is not. */
function oddity(value, { kind }) {
  if (kind === 'bool') return typeof value === 'number' ? 'a bool, but neither 0 nor 1' : null;
  if (typeof value !== 'number') return null;
  if (Number.isNaN(value)) return 'NaN';
  return Number.isFinite(value) ? null : 'infinite';
}

/** The components of a vector place, in the order of their bytes. */
function components(view, place) {
  const { leaf } = place.member;
  const found = [];
  for (let at = place.start; at < place.end; at += leaf.width) {
    if (at + leaf.width > view.byteLength) break;
    const value = component(view, at, leaf);
    found.push({ start: at, value, text: valueText(value, leaf), odd: oddity(value, leaf) });
  }
  return found;
}

/** Calls `leaf` with every vector place of a block, `padding` with every unused range. */
function visit(place, visitor) {
  if (place.kind === 'array') {
    for (let index = 0; index < place.count; index += 1) {
      partsOfElement(place, index).forEach((part) => visit(part, visitor));
    }
  } else if (place.kind === 'struct') partsOfStruct(place).forEach((part) => visit(part, visitor));
  else if (place.kind === 'leaf') partsOfLeaf(place).forEach((part) => visit(part, visitor));
  else if (place.kind === 'padding') visitor.padding(place);
  else visitor.vector(place);
}

/** Everything suspicious in the bytes of a block, by offset. */
function oddities(layout, view) {
  const endless = layout.members.some(isEndless);
  const length = endless ? view.byteLength : Math.min(view.byteLength, layout.size);
  const used = new Uint8Array(length);
  const found = [];
  visit(blockPlace(layout, view.byteLength), {
    vector(place) {
      used.fill(1, place.start, place.end);
      for (const { start, odd, text: shown } of components(view, place)) {
        if (!odd) continue;
        const { path } = componentOf(place, start);
        const what = odd === 'NaN' ? 'not a number' : odd;
        found.push({ start, what: `\`${path}\` at byte ${start} is ${what}: ${shown}` });
      }
    },
    padding() {},
  });
  for (let at = 0; at < length; at += 1) {
    if (used[at]) continue;
    let end = at;
    let [first, last] = [null, null];
    for (; end < length && !used[end]; end += 1) {
      if (view.getUint8(end) !== 0) [first, last] = [first ?? end, end];
    }
    if (first !== null) found.push({ start: first, padding: true, what: stray(view, first, last + 1) });
    at = end;
  }
  found.sort((a, b) => a.start - b.start);
  return { list: found.slice(0, MAX_ODD), more: Math.max(0, found.length - MAX_ODD) };
}

function stray(view, start, end) {
  const shown = [];
  for (let at = start; at < Math.min(end, start + 16); at += 1) {
    shown.push(view.getUint8(at).toString(16).padStart(2, '0'));
  }
  const rest = end - start > 16 ? ` … (${end - start} bytes)` : '';
  return `padding at byte ${start} is not zero: ${shown.join(' ')}${rest}`;
}

/** Why bytes cannot be those of a block, or a remark on their number; `null` if all fits. */
function lengthRemark(layout, length) {
  const endless = layout.members.some(isEndless);
  const ends = layout.members.filter((member) => !isEndless(member)).map((member) => member.offset + (member.size ?? 0));
  const needed = Math.max(0, ...ends);
  if (length < needed) {
    return { refused: true, what: `${bytes(length)} are too few: the block's members need ${bytes(needed)}` };
  }
  if (length < layout.size) {
    return { refused: false, what: `${bytes(length)}, but a buffer for the block must hold ${bytes(layout.size)}` };
  }
  if (length > layout.size && !endless) {
    return { refused: false, what: `${bytes(length - layout.size)} follow the ${bytes(layout.size)} of the block` };
  }
  return null;
}
