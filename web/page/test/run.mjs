// SPDX-License-Identifier: BSD-3-Clause
// node test/run.mjs [unit|browser] : bundles the tests for node and runs them.
import {spawnSync} from 'node:child_process';
import {mkdtempSync, readdirSync, rmSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const wanted = process.argv[2] === 'browser' ? /\.browser\.ts$/ : /\.test\.ts$/;
const files = readdirSync(here).filter((name) => wanted.test(name));
const out = mkdtempSync(join(here, '..', '.test-'));
try {
  await build({
    entryPoints: files.map((name) => join(here, name)), bundle: true, outdir: out, format: 'esm', platform: 'node',
    target: 'node18', outExtension: {'.js': '.mjs'}, packages: 'external', sourcemap: 'inline', logLevel: 'warning',
  });
  const run = spawnSync(process.execPath, ['--test', '--test-concurrency=1', ...readdirSync(out).map((name) => join(out, name))], {
    stdio: 'inherit', env: {...process.env, CAS_PAGE: process.env.CAS_PAGE ?? join(here, '..', 'dist')},
  });
  process.exitCode = run.status ?? 1;
} finally {
  rmSync(out, {recursive: true, force: true});
}
