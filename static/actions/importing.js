// Files from elsewhere for the open session: motion, keypoints, a camera. One is brought to the
// server, which says what it holds; then imported as somebody chose.

import { orderOf, usualOf, whyNotOrder } from '../controls/order_form.js';
import { toast } from '../controls/toasts.js';
import { bytes } from '../controls/words.js';
import { ENDINGS, IMPORTS } from '../store/orders.js';
import { server, setUi, ui } from '../store/state.js';
import { fetchOk } from './exporting.js';
import { follow, leave } from './following.js';
import { beginReduction } from './proposals.js';

const LARGEST = 256 * 2 ** 20;

/** @typedef {import('../store/shapes.js').Importing} Importing */

/** Whether a name is one of what can be imported. @param {string} name */
export const isImported = (name) => ENDINGS.some((ending) => name.toLowerCase().endsWith(ending));

/** Whether a file may be one frame of OpenPose's or Pose2Sim's. @param {{ name: string }} file */
export const isOpenPose = ({ name }) => /\d.*\.json$/.test(name);

/**
 * Import the frames of OpenPose, each a file, as one.
 * @param {string} name  Of all of them.
 * @param {File[]} files
 */
export async function importOpenPose(name, files) {
  try {
    importFile(await openPoseFile(name, files));
  } catch (error) {
    toast({ kind: 'check', words: error.message });
  }
}

/**
 * OpenPose's frames in one file: a list of what each holds, with its name.
 * @param {string} name
 * @param {{ name: string, text: () => Promise<string> }[]} files
 */
export async function openPoseFile(name, files) {
  const frames = [];
  for (const file of files) {
    try {
      frames.push({ ...JSON.parse(await file.text()), file_name: file.name });
    } catch {
      throw new Error(`${file.name} is not JSON.`);
    }
  }
  return new File([JSON.stringify(frames)], `${name}.json`);
}

/** Ask for a file, and import it. */
export function chooseImport() {
  const input = document.createElement('input');
  input.type = 'file';
  input.accept = ENDINGS.join();
  input.addEventListener('change', () => input.files?.[0] && importFile(input.files[0]));
  input.click();
}

/** Bring a file to the server, and show what it holds. @param {File} file */
export async function importFile(file) {
  if (ui.importing?.stage === 'importing') {
    toast({ kind: 'check', words: `${ui.importing.name} is still being imported. Cancel it first.` });
    return;
  }
  const name = file.name;
  if (file.size > LARGEST) {
    toast({
      kind: 'check',
      words: `${name} is too large to import. It has ${bytes(file.size)}, ${bytes(LARGEST)} are allowed.`,
    });
    return;
  }
  /** @type {Importing} */
  const begun = { stage: 'reading', id: '', name, found: null, words: '', done: 0, of: 0, choices: {} };
  let id = '';
  show(begun);
  try {
    const response = await fetchOk(`/imports?${new URLSearchParams({ name })}`, { method: 'POST', body: file });
    ({ id } = await response.json());
    if (ui.importing !== begun) return void leave(addressOf(id)); // closed meanwhile, or it is another file's turn
    show({ ...begun, id });
    await followStage(id);
  } catch (error) {
    if (ui.importing === begun || isShown(id)) fail(error.message);
  }
}

/** Import it as it is chosen in the dialog. */
export async function beginImport() {
  const { importing } = ui;
  if (!importing?.found || importing.stage === 'importing') return;
  show({ ...importing, stage: 'importing', words: '', done: 0, of: 0 });
  try {
    const order = JSON.stringify(importOrder(importing.found, importing.choices));
    await fetchOk(addressOf(importing.id), { method: 'POST', body: order });
    await followStage(importing.id);
  } catch (error) {
    if (isShown(importing.id)) fail(error.message);
  }
}

/** Close the dialog, and end what is under way. */
export function leaveImport() {
  const { importing } = ui;
  setUi('importing', null);
  if (!importing?.id) return;
  leave(addressOf(importing.id));
  if (importing.stage === 'importing') toast({ kind: 'info', words: 'Import cancelled.' });
}

/**
 * The options of an import in the order of its form, and what is known of them from the file.
 * @param {import('../store/shapes.js').Recognised} found
 */
export function optionsOf({ kind, facts }) {
  const options = IMPORTS[kind];
  /** @type {Record<string, import('../controls/order_form.js').Further>} */
  const further = { places: { out: !facts.left_out?.length } };
  const named = (id) => ({ id, label: id });
  if (kind !== 'camera') {
    const several = facts.individuals.length > 0;
    further.individual = { out: !several, needed: several, options: facts.individuals.map(named) };
  }
  if (kind === 'camera') further.rotation_order = further.lens_column = { out: !facts.columns };
  if (kind === 'keypoints') {
    const several = facts.layouts.length > 0;
    further.layout = { out: !several, needed: several, options: facts.layouts.map(named) };
    further.every = { empty: String(facts.every) };
  }
  if (kind === 'motion') {
    const label = (name, id) =>
      options
        .find((one) => one.name === name)
        ?.options?.find((one) => one.id === id)
        ?.label.toLowerCase();
    const said = (name, id) => (id ? { empty: `As the file says: ${label(name, id)}` } : {});
    further.fps = facts.fps ? { empty: String(Number(facts.fps.toFixed(2))) } : {};
    further.unit = said('unit', facts.unit);
    further.world = {
      ...said('world', facts.world?.replace(' ', '-')),
      ...(facts.keyframes ? { note: 'Keyframes decide' } : {}),
    };
  }
  return { options, further };
}

/** The order that the server takes. */
export function importOrder(found, choices) {
  const { options, further } = optionsOf(found);
  return { kind: found.kind, ...orderOf(options, choices, further) };
}

/**
 * What is wrong with the choices, a sentence, or ''.
 * @param {import('../store/shapes.js').Recognised} found
 * @param {import('../controls/order_form.js').Values} choices
 * @param {number} count  Of the video's frames.
 */
export function whyNotBegin(found, choices, count) {
  const { options, further } = optionsOf(found);
  const both =
    choices.every && choices.frames
      ? 'Drafts are every so many frames or at the frames that are listed: leave one empty.'
      : '';
  return whyNotOrder(options, choices, count, further) || both;
}

/**
 * What a name of a file can mean: every joint of the body, the free ends of its parts, its landmarks.
 * @param {import('../store/shapes.js').Part[]} parts
 */
export function placesOfBody(parts) {
  const hasChild = new Set(parts.map(({ parent }) => parent));
  return parts
    .flatMap(({ name, label, landmarks }) => [
      { id: name, label, group: 'Joints' },
      ...(hasChild.has(name) ? [] : [{ id: `${name}.end`, label: `${label}, end`, group: 'Ends' }]),
      ...landmarks.map((mark) => ({
        id: `${name}.${mark}`,
        label: capitalised(mark.replaceAll('_', ' ')),
        group: 'Points',
      })),
    ])
    .sort((a, b) => GROUPS.indexOf(a.group) - GROUPS.indexOf(b.group));
}

const GROUPS = ['Joints', 'Ends', 'Points'];
const capitalised = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);

// --- what is under way

/** Whether the dialog is still about this file. @param {string} id */
const isShown = (id) => id !== '' && ui.importing?.id === id;

/** @param {Importing} importing */
const show = (importing) => setUi('importing', importing);

/** What was not possible is said in the dialog, where it can be mended. */
function fail(words) {
  const { importing } = ui;
  if (!importing) return;
  show({ ...importing, stage: importing.found ? 'choosing' : 'failed', words });
}

/** Look how far it is until the stage is over. */
async function followStage(id) {
  const state = await follow(
    addressOf(id),
    () => isShown(id),
    ({ done, of }) => show({ ...ui.importing, done, of }),
  );
  if (state) takeIn(state);
}

const addressOf = (id) => `/imports/${id}`;

/** Whether there is a motion besides that which was imported. */
const isPosed = () => (server.keys?.frames.length ?? 0) > 1 || (server.keys?.drafts.length ?? 0) > 1;

/** Before it has keyframes an imported motion is not seen. */
const REDUCE = { button: { label: 'Reduce to keyframes…', run: beginReduction }, brief: true };

function takeIn(state) {
  if (state.state !== 'done') fail(state.words);
  else if (state.stage === 'reading') {
    show({ ...ui.importing, stage: 'choosing', found: state.found, choices: usualOf(IMPORTS[state.found.kind]) });
  } else {
    const { id, found } = ui.importing;
    setUi('importing', null);
    leave(addressOf(id));
    const read = state.doubtful ? { button: { label: 'OK', run: () => {} } } : {}; // a doubt stays until it is read
    const offer = found?.kind === 'motion' && !isPosed() ? { ...REDUCE, brief: !state.doubtful } : read;
    toast({
      kind: state.doubtful ? 'check' : 'good',
      words: state.words,
      ...(state.detail ? { detail: state.detail } : {}),
      ...offer,
    });
  }
}
