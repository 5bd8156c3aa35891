// What Esc ends, the nearest first: a menu, the focus of a control, the guide, the job.

import { closeGuide } from './guide.js';
import { leaveControl } from './focus.js';
import { cancelJob } from './job.js';
import { closeMenu } from './menus.js';

/** End one thing; tells whether there was anything. An open dialog closes itself. */
export function escape() {
  if (document.querySelector('dialog[open]')) return false;
  return closeMenu() || leaveControl() || closeGuide() || cancelJob();
}
