// Run by node where three and gltf-validator are installed: FILE FPS FRAME …; prints JSON.

import fs from 'node:fs';
import * as THREE from 'three';
import validator from 'gltf-validator';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

globalThis.self ??= globalThis; // the loader looks for a browser's
const [file, fps, ...frames] = process.argv.slice(2);
const bytes = new Uint8Array(fs.readFileSync(file));
const gltf = await new GLTFLoader().parseAsync(bytes.buffer, '');
const mixer = new THREE.AnimationMixer(gltf.scene);
const action = mixer.clipAction(gltf.animations[0]);
action.setLoop(THREE.LoopOnce, 1);
action.clampWhenFinished = true;
action.play();

const skins = [];
gltf.scene.traverse((node) => node.isSkinnedMesh && skins.push(node));
const names = gltf.parser.json.nodes.map(({ name }) => name); // the loader strips dots and colons
const { bones } = skins[0].skeleton;

function at(frame) {
  mixer.setTime(frame / Number(fps));
  gltf.scene.updateMatrixWorld(true);
  const places = bones.map((bone, i) => [names[gltf.parser.json.skins[0].joints[i]], bone.getWorldPosition(new THREE.Vector3()).toArray()]);
  return { bones: Object.fromEntries(places), lowest: Math.min(...skins.map(lowest)) };
}

function lowest(skin) {
  skin.skeleton.update();
  let least = Infinity;
  for (let i = 0; i < skin.geometry.attributes.position.count; i += 1) {
    const p = skin.getVertexPosition(i, new THREE.Vector3()).applyMatrix4(skin.matrixWorld);
    least = Math.min(least, p.y);
  }
  return least;
}

const { issues } = await validator.validateBytes(bytes);
const said = { revision: THREE.REVISION, frames: frames.map((frame) => at(Number(frame))), errors: issues.numErrors, warnings: issues.numWarnings };
process.stdout.write(JSON.stringify(said));
