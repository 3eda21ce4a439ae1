// Prints Tint's messages about a WGSL file; exits with 1 if it is refused. Dawn's null backend
// compiles without a GPU.
//
// node tint.mjs DIRECTORY_OF_NODE_MODULES FILE
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [directory, file] = process.argv.slice(2);
const resolve = createRequire(pathToFileURL(`${directory}/package.json`)).resolve;
const { create } = await import(pathToFileURL(resolve('webgpu')));
const gpu = create(['backend=null']);
const device = await (await gpu.requestAdapter()).requestDevice();
device.pushErrorScope('validation');
const module = device.createShaderModule({ code: readFileSync(file, 'utf8') });
const { messages } = await module.getCompilationInfo();
await device.popErrorScope();
for (const { lineNum, linePos, type, message } of messages) {
  console.log(`${file}:${lineNum}:${linePos} ${type}: ${message}`);
}
process.exit(messages.some(({ type }) => type === 'error') ? 1 : 0);
