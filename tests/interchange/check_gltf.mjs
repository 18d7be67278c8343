// Runs the Khronos validator over glTF files.
//
// Usage: node check_gltf.mjs FOLDER_OF_THE_PACKAGE FILE...
// Prints one JSON object: for each file its faults. Warnings count; hints and extensions that the validator does not know do not.

import fs from "node:fs";
import path from "node:path";
import { createRequire } from "node:module";

const WARNING = 1;
const [folder, ...files] = process.argv.slice(2);
const validator = createRequire(path.join(path.resolve(folder), "x.js"))("gltf-validator");
const report = {};
for (const file of files) {
    const beside = path.dirname(path.resolve(file));
    const result = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
        maxIssues: 0,
        externalResourceFunction: async (uri) => new Uint8Array(fs.readFileSync(path.join(beside, decodeURIComponent(uri)))),
    });
    const counts = (issue) => issue.severity <= WARNING && issue.code !== "UNSUPPORTED_EXTENSION";
    report[file] = { faults: result.issues.messages.filter(counts).map((issue) => `${issue.pointer}: ${issue.message}`) };
}
process.stdout.write(JSON.stringify(report));
