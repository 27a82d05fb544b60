// Runs the Khronos validator over files: node validate_gltf.js FILE...   (npm install gltf-validator; NODE_PATH may say where)
// Prints one line a file; exits with 1 on any error or warning, with 77 where the validator is not installed.
const fs = require('fs');
const path = require('path');

let validator;
try {
    validator = require('gltf-validator');
} catch (error) {
    console.log('gltf-validator is not installed');
    process.exit(77);
}

async function main() {
    let bad = 0;
    for (const file of process.argv.slice(2)) {
        const readBeside = async (uri) => new Uint8Array(fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(uri))));
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {externalResourceFunction: readBeside});
        const issues = report.issues;
        console.log(`${path.basename(file)}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} notes`);
        for (const message of issues.messages)
            if (message.severity < 2) console.log(`  ${message.code} ${message.pointer}: ${message.message}`);
        bad += issues.numErrors + issues.numWarnings;
    }
    process.exit(bad === 0 ? 0 : 1);
}
main();
