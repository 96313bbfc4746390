// SPDX-License-Identifier: BSD-3-Clause
// node build.mjs FOLDER: writes index.html with its assets (for casweb, each with its .gz beside it), replay.html (all in
// one file, with a place for records) and licences.txt. Fails when the app is larger than its budget.
import {createHash} from 'node:crypto';
import {existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync} from 'node:fs';
import {dirname, join, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';
import {gzipSync} from 'node:zlib';
import {build} from 'esbuild';

const kBudget = 250_000;  // bytes, gzip -9

const here = dirname(fileURLToPath(import.meta.url));
const out = resolve(process.argv[2] ?? join(here, 'dist'));
const common = {
  absWorkingDir: here, entryPoints: ['src/main.ts'], bundle: true, minify: true, target: 'es2022', write: false, metafile: true,
  legalComments: 'none', loader: {'.ts': 'ts'}, outdir: '/', define: {'process.env.NODE_ENV': '"production"', kOneFile: 'false'},
  conditions: ['production'],
};

/** Names and licence texts of the packages that are in bundles. */
function licences(...metafiles) {
  const packages = new Set();
  for (const input of metafiles.flatMap(({inputs}) => Object.keys(inputs))) {
    const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (found) packages.add(found[1]);
  }
  return [...packages].sort().map((name) => {
    const folder = join(here, 'node_modules', name);
    const {version, license} = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
    const file = readdirSync(folder).find((each) => /^licen[cs]e/i.test(each));
    if (!file) throw new Error(`${name} has no licence file`);
    return `${name} ${version} (${license})\n\n${readFileSync(join(folder, file), 'utf8').trim()}\n`;
  }).join('\n\n');
}

const hashOf = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;
const shortHash = (bytes) => createHash('sha256').update(bytes).digest('hex').slice(0, 12);
const output = (result, ending) => result.outputFiles.find((file) => file.path.endsWith(ending)).text.trim();

// One file: app, 3D view and records are compressed in it; a small script unpacks and runs the app, which does the same
// with the view after its first frame. The policy names the hashes of all three.
const single = await build({...common, define: {...common.define, kOneFile: 'true'}, format: 'iife'});
const view = await build({...common, entryPoints: ['src/scene3d.ts'], format: 'iife', globalName: 'casView'});
const texts = licences(single.metafile, view.metafile);
const js = output(single, '.js');
const viewJs = `/*! CAS, BSD-3-Clause; with:\n\n${texts.replaceAll('*/', '* /')}\n*/\n${output(view, '.js')}`;
const css = output(single, '.css');
const boot = 'async function casRun(id){const t=atob(document.getElementById(id).textContent.trim());' +
  'const b=new Uint8Array(t.length);for(let i=0;i<b.length;++i)b[i]=t.charCodeAt(i);' +
  "const s=document.createElement('script');" +
  "s.textContent=await new Response(new Blob([b]).stream().pipeThrough(new DecompressionStream('gzip'))).text();" +
  "document.body.append(s)}casRun('app')";
const [packed, packedView] = [js, viewJs].map((text) => gzipSync(text, {level: 9}));
const replay = readFileSync(join(here, 'src/replay.html'), 'utf8')
  .replace('SCRIPT_HASHES', () => [boot, js, viewJs].map(hashOf).join(' '))
  .replace('STYLE_HASH', () => hashOf(css))
  .replace('PAGE_CSS', () => css)
  .replace('PAGE_APP', () => packed.toString('base64'))
  .replace('PAGE_VIEW', () => packedView.toString('base64'))
  .replace('BOOT_JS', () => boot);

// Files for casweb: the 3D view is a part of its own, loaded beside the frame of the page.
const split = await build({...common, format: 'esm', splitting: true, entryNames: 'page-[hash]', chunkNames: 'part-[hash]'});
if (existsSync(join(out, 'assets'))) rmSync(join(out, 'assets'), {recursive: true});
mkdirSync(join(out, 'assets'), {recursive: true});
const writeAsset = (name, bytes) => {
  writeFileSync(join(out, 'assets', name), bytes);
  writeFileSync(join(out, 'assets', `${name}.gz`), gzipSync(bytes, {level: 9}));
};
let entry = '';
const parts = [];  // fetched beside the entry, not after it has run
for (const file of split.outputFiles) {
  const name = file.path.split('/').pop();
  if (name.endsWith('.js')) writeAsset(name, file.contents);
  if (/^page-.*\.js$/.test(name)) entry = name;
  if (/^part-.*\.js$/.test(name)) parts.push(name);
}
const cssName = `page-${shortHash(css)}.css`;
writeAsset(cssName, css);
const index = readFileSync(join(here, 'src/index.html'), 'utf8')
  .replace('PAGE_CSS', `/assets/${cssName}`)
  .replace('PAGE_PARTS', () => parts.map((name) => `<link rel="modulepreload" href="/assets/${name}">\n`).join(''))
  .replace('PAGE_JS', `/assets/${entry}`);
// The plots of report.html, which hils puts into each report.
const report = await build({...common, entryPoints: ['src/report.ts'], format: 'iife'});
writeFileSync(join(out, 'report.js'), `/*! CAS, BSD-3-Clause; with:\n\n${licences(report.metafile).replaceAll('*/', '* /')}\n*/\n${output(report, '.js')}`);
writeFileSync(join(out, 'report.css'), output(report, '.css'));
// The script of runs.html, which hils puts into that page.
const runs = await build({...common, entryPoints: ['src/runs.ts'], format: 'iife'});
writeFileSync(join(out, 'runs.js'), output(runs, '.js'));
writeFileSync(join(out, 'runs.css'), output(runs, '.css'));
writeFileSync(join(out, 'licences.txt'), texts);
writeFileSync(join(out, 'replay.html'), replay);
writeFileSync(join(out, 'index.html'), index);  // last: its presence says that the page is whole

const whole = packed.length + packedView.length + gzipSync(css, {level: 9}).length;
console.log(`page: ${((js.length + viewJs.length) / 1000).toFixed(0)} kB, ${(whole / 1000).toFixed(1)} kB compressed (budget ${kBudget / 1000} kB)`);
if (whole > kBudget) {
  console.error('page: over its budget');
  process.exit(1);
}
