// Values written into a text of JSON where they differ from its own: all else stays as it is spelled.

/** The tree of a text in JSON that is known to be well formed: values with their places. */
function jsonTree(text) {
  let at = 0;
  const space = () => { while (' \t\r\n'.includes(text[at] ?? 'x')) at += 1; };
  const value = () => {
    space();
    const start = at;
    const node = { start, items: null, keys: null };
    if (text[at] === '{' || text[at] === '[') {
      const close = text[at] === '{' ? '}' : ']';
      Object.assign(node, { items: [], keys: close === '}' ? [] : null });
      at += 1;
      for (space(); text[at] !== close; space()) {
        if (text[at] === ',') at += 1;
        space();
        const from = at;
        if (node.keys) {
          node.keys.push(JSON.parse(string()));
          space();
          at += 1;
        }
        node.items.push({ from, ...value() });
      }
      at += 1;
    } else if (text[at] === '"') string();
    else while (at < text.length && !' \t\r\n,]}'.includes(text[at])) at += 1;
    node.end = at;
    if (!node.items) node.value = JSON.parse(text.slice(start, at));
    return node;
  };
  const string = () => {
    const start = at;
    for (at += 1; text[at] !== '"'; at += 1) if (text[at] === '\\') at += 1;
    at += 1;
    return text.slice(start, at);
  };
  return value();
}

/** The value of a node. */
const valueOf = ({ items, keys, value }) => {
  if (!items) return value;
  return keys ? Object.fromEntries(keys.map((key, at) => [key, valueOf(items[at])])) : items.map(valueOf);
};

/** Whether two values of JSON are the same. */
function isSame(a, b) {
  if (a === null || b === null || typeof a !== 'object' || typeof b !== 'object') return Object.is(a, b) || a === b;
  if (Array.isArray(a) !== Array.isArray(b)) return false;
  const [first, second] = [Object.keys(a), Object.keys(b)];
  return first.length === second.length && first.every((key) => key in b && isSame(a[key], b[key]));
}

/** A text of JSON with other values: only what differs is written, in the form of what is around it. */
function withValues(text, wanted) {
  const edits = [];
  const put = (start, end, written) => edits.push([start, end, written]);
  const indentOf = (node) => /[ \t]*$/.exec(text.slice(0, node.from ?? node.start))[0];
  const inLines = ({ items, start }) => items.length > 0 && text.slice(start, items[0].from).includes('\n');
  const inOne = (value) => {
    if (typeof value !== 'object' || value === null) return JSON.stringify(value);
    if (Array.isArray(value)) return `[${value.map(inOne).join(', ')}]`;
    return `{${Object.entries(value).map(([key, one]) => `${JSON.stringify(key)}: ${inOne(one)}`).join(', ')}}`;
  };
  /** A value in one line, or its members and elements in a line each, as those of its model are. */
  const spelled = (value, model, indent) => {
    const isLong = model ? model.items && inLines(model) : inOne(value).length > 80;
    if (!isLong || typeof value !== 'object' || value === null) return inOne(value);
    const isList = Array.isArray(value);
    const lines = Object.entries(value).map(([key, one]) => `${indent}  ${isList ? '' : `${JSON.stringify(key)}: `}${spelled(one, null, `${indent}  `)}`);
    return `${isList ? '[' : '{'}\n${lines.join(',\n')}\n${indent}${isList ? ']' : '}'}`;
  };
  /** Adds members or elements behind the last one. */
  const append = (node, all) => {
    if (all.length === 0) return;
    const last = node.items.at(-1);
    const model = node.keys ? null : last;
    const isLines = last ? inLines(node) : true;
    const indent = last ? indentOf(last) : `${indentOf({ start: text.lastIndexOf('\n', node.start) + 1 + /^[ \t]*/.exec(text.slice(text.lastIndexOf('\n', node.start) + 1))[0].length })}  `;
    const gap = isLines ? `\n${indent}` : ' ';
    const lines = all.map(([key, value]) => `${key === null ? '' : `${JSON.stringify(key)}: `}${spelled(value, model, indent)}`);
    if (last) put(last.end, last.end, lines.map((line) => `,${gap}${line}`).join(''));
    else put(node.start + 1, node.end - 1, `\n${indent}${lines.join(`,${gap}`)}\n${indent.slice(2)}`);
  };
  /** Takes members or elements out, with a comma beside each. */
  const remove = (node, gone) => {
    const { items } = node;
    if (gone.length === items.length) {
      if (items.length > 0) put(node.start + 1, node.end - 1, '');
      return;
    }
    const kept = items.findIndex((_, at) => !gone.includes(at));
    // Those before the first that stays go with the comma behind them, the others with that before.
    for (const at of gone) put(at < kept ? items[at].from : items[at - 1].end, at < kept ? items[at + 1].from : items[at].end, '');
  };
  const visit = (node, value) => {
    if (isSame(valueOf(node), value)) return;
    const isObject = (one) => typeof one === 'object' && one !== null && !Array.isArray(one);
    if (node.keys && isObject(value) && node.keys.some((key) => key in value)) {
      node.keys.forEach((key, at) => key in value && visit(node.items[at], value[key]));
      append(node, Object.entries(value).filter(([key]) => !node.keys.includes(key)));
      remove(node, node.keys.flatMap((key, at) => (key in value ? [] : [at])));
    } else if (node.items && !node.keys && Array.isArray(value)) {
      // What is the same at both ends stays; what is between is changed one by one.
      const { items } = node;
      const least = Math.min(items.length, value.length);
      let head = 0;
      while (head < least && isSame(valueOf(items[head]), value[head])) head += 1;
      let tail = 0;
      while (tail < least - head && isSame(valueOf(items.at(-1 - tail)), value.at(-1 - tail))) tail += 1;
      const [from, to] = [items.length - tail, value.length - tail];
      if (tail > 0 && to > from) {
        put(node.start, node.end, spelled(value, node, indentOf(node)));
        return;
      }
      for (let at = head; at < Math.min(from, to); at += 1) visit(items[at], value[at]);
      append(node, value.slice(from, to).map((one) => [null, one]));
      remove(node, Array.from({ length: Math.max(0, from - to) }, (_, at) => to + at));
    } else put(node.start, node.end, spelled(value, null, indentOf(node)));
  };
  visit(jsonTree(text), wanted);
  return edits.sort(([a], [b]) => b - a).reduce((now, [start, end, written]) => now.slice(0, start) + written + now.slice(end), text);
}
