// Every message of the table of actions, as JSON, for a test to hold against what the program takes.

import './browser.js';
import { server, ui } from '../../static/store/state.js';
import { ACTIONS } from '../../static/actions/table.js';

server.file = { frames: 60, id: '0123456789abcdef' };
server.view = { frame: 4, selected: 'left_hand', mode: 'both' };
server.body = { parts: [{ name: 'left_hand', landmarks: [] }] };
server.keys = { frames: [0, 8], drafts: [] };
server.films = [{ id: 'film-2', begins: 3.4, also: [31.5] }];
server.bodies = [
  { id: 'body', posed: true, called: '', keys: [] },
  { id: 'body-2', posed: false, called: '', keys: [] },
];
ui.fitFocal = true;
ui.box = [10, 20, 30, 80];
const kept = { id: '0123456789ab', name: 'Sitting', fits: true };
const about = {
  addBody: 'adult_male',
  draftAll: [
    [10, 20, 30, 80],
    [40, 20, 60, 80],
  ],
  insertPose: kept,
  insertMirrored: kept,
  openRecent: { id: 'a' },
  softKeys: [0, 8],
  pinCorner: { part: 'left_hand', at: [10, 20] },
  unkeyLimb: { frame: 4, parts: ['left_hand'] },
};
const messages = Object.entries(ACTIONS).flatMap(([id, { message }]) => (message ? [[id, message(about[id])]] : []));
process.stdout.write(JSON.stringify(Object.fromEntries(messages)));
