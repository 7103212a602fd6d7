// Runs Khronos' glTF validator over FILE... and prints one JSON line a file: {file, errors, warnings, messages}.
// Exit status 0 no errors, 1 errors, 77 the module gltf-validator is absent (`npm install` in this folder).

import { readFile } from "node:fs/promises";

let validator;
try {
  validator = (await import("gltf-validator")).default;
} catch {
  console.error("the module gltf-validator is absent; run npm install in tests/tools");
  process.exit(77);
}

let failed = false;
for (const file of process.argv.slice(2)) {
  const bytes = new Uint8Array(await readFile(file));
  const report = await validator.validateBytes(bytes, { maxIssues: 200 });
  const { numErrors, numWarnings, messages } = report.issues;
  const told = messages.filter((m) => m.severity <= 1).map((m) => `${m.code} ${m.pointer}: ${m.message}`);
  console.log(JSON.stringify({ file, errors: numErrors, warnings: numWarnings, messages: told }));
  failed ||= numErrors > 0;
}
process.exitCode = failed ? 1 : 0;
