// What the page says of a dropped file that is no video.

import assert from 'node:assert/strict';
import test from 'node:test';

import './browser.js';

const { whyNotVideo } = await import('../../static/start/uploading.js');

test('what belongs to a session is imported once one is open', () => {
  for (const name of ['Walk.BVH', 'dogDLC.h5', 'hmr4d_results.pt', 'poses.npz']) {
    assert.match(whyNotVideo(name), new RegExp(`${name} is not a video. Open the video first`));
  }
});

test('a session is opened where it lies, and anything else is no video', () => {
  assert.match(whyNotVideo('session.json'), /opened where it lies/);
  assert.match(whyNotVideo('notes.txt'), /notes\.txt is not a video\. Keypose opens MP4/);
});
