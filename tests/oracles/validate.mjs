// Prints the errors and warnings of Khronos' gltf-validator for the files that standard input lists: {file: [message]}.
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

const WARNING = 1;
const found = {};
for (const file of JSON.parse(readFileSync(0, 'utf8'))) {
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)), { uri: file });
  const serious = issues.messages.filter(({ severity }) => severity <= WARNING);
  found[file] = serious.map(({ code, message, pointer }) => `${code} ${pointer}: ${message}`);
}
console.log(JSON.stringify(found));
