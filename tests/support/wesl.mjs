// Links WESL with the package `wesl`: reads a JSON list of [sources by path, conditions], of which
// `main.wesl` is the root, and prints a JSON list of WGSL texts.
//
// node wesl.mjs DIRECTORY_OF_NODE_MODULES < JSON
import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [directory] = process.argv.slice(2);
const { link } = await import(pathToFileURL(`${directory}/node_modules/wesl/dist/index.js`));
const texts = [];
for (const [weslSrc, conditions] of JSON.parse(readFileSync(0, 'utf8'))) {
  texts.push((await link({ weslSrc, rootModuleName: 'main', conditions })).dest);
}
console.log(JSON.stringify(texts));
