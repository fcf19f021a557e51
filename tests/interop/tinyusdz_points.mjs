// Prints the first mesh of a file of USD as TinyUSDZ reads it, a JSON object: points, normals, faceVertexIndices.
//
// usage: node tinyusdz_points.mjs PACKAGE FILE
//        PACKAGE: folder of the npm package tinyusdz

import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

// The package is built for browsers alone; this is enough of one for it.
process.type = "renderer";
globalThis.window = globalThis;
const [folder, file] = process.argv.slice(2);
const url = pathToFileURL(path.resolve(folder, "tinyusdz.js")).href;
globalThis.document = { currentScript: { src: url } };

const start = (await import(url)).default;
const usd = await start({ wasmBinary: fs.readFileSync(path.join(folder, "tinyusdz.wasm")) });
const loader = new usd.TinyUSDZLoaderNative();
if (!loader.loadFromBinary(new Uint8Array(fs.readFileSync(file)), file) || loader.numMeshes() < 1) {
    console.error(loader.error());
    process.exit(1);
}
const mesh = loader.getMesh(0);
const numbers = (name) => Array.from(mesh[name]);
console.log(JSON.stringify(Object.fromEntries(["points", "normals", "faceVertexIndices"].map((n) => [n, numbers(n)]))));
