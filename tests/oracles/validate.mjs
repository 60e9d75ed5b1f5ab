// Prints the errors and warnings that the Khronos glTF validator finds in files, as JSON.
import fs from 'node:fs';
import validator from 'gltf-validator';
for (const file of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
  console.log(JSON.stringify(issues.messages.filter((one) => one.severity < 2)));
}
