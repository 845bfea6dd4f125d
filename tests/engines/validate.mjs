// Validates files with the Khronos glTF validator and prints for each file:
//   FILE errors COUNT warnings COUNT tangents COUNT
// tangents: infos that a normal map has no tangents in the file. Errors, warnings and the codes of infos follow.
//   node validate.mjs FILE.glb...
import { readFileSync } from "node:fs";
import { validateBytes } from "gltf-validator";

const ERROR = 0, WARNING = 1;

for (const file of process.argv.slice(2)) {
    const { issues } = await validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 0 });
    const codes = issues.messages.map(({ code }) => code);
    const tangents = codes.filter((code) => code === "MESH_PRIMITIVE_GENERATED_TANGENT_SPACE").length;
    console.log(`${file} errors ${issues.numErrors} warnings ${issues.numWarnings} tangents ${tangents}`);
    for (const { severity, code, message, pointer } of issues.messages)
        if (severity <= WARNING)
            console.log(`  ${severity === ERROR ? "error" : "warning"} ${code} ${pointer}: ${message}`);
    console.log(`  codes ${[...new Set(codes)].sort().join(" ")}`);
}
