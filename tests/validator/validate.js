// SPDX-License-Identifier: GPL-3.0-or-later
'use strict';

// Runs the Khronos glTF validator over the files given. Exit status 0: no error
// and no warning; 1: some; 2: it could not run.

const fs = require('fs');

let validator;
try {
  validator = require('gltf-validator');
} catch (error) {
  console.error('gltf-validator is not installed; run: npm ci --prefix tests/validator');
  process.exit(2);
}

const severities = ['error', 'warning', 'info', 'hint'];

async function validate(file) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {uri: file, maxIssues: 0});
  for (const issue of report.issues.messages) {
    console.log(`${file}: ${severities[issue.severity]}: ${issue.code}: ${issue.message} (${issue.pointer})`);
  }
  const {numErrors, numWarnings, numInfos} = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos`);
  return numErrors === 0 && numWarnings === 0;
}

async function main(files) {
  if (files.length === 0) throw new Error('usage: node validate.js FILE.glb...');
  let valid = true;
  for (const file of files) valid = await validate(file) && valid;
  process.exit(valid ? 0 : 1);
}

main(process.argv.slice(2)).catch((error) => {
  console.error(String(error));
  process.exit(2);
});
