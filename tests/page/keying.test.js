// Which keyframe's pose comes to the playhead.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { copyKey } from '../../static/actions/keying.js';
import { server } from '../../static/store/state.js';

test('the pose of the keyframe before or after the playhead is copied to it', () => {
  const keys = { frames: [0, 24, 48, 72], drafts: [30] };
  Object.assign(server, { file: { frames: 73 }, view: { frame: 30 }, keys });
  assert.deepEqual(copyKey(-1), { do: 'copy_key', from_frame: 24 });
  assert.deepEqual(copyKey(1), { do: 'copy_key', from_frame: 48 });
});
