// What Esc ends, the nearest first: a sheet, a menu, the focus of a control, what was told of a fit,
// the guide, the job.

import { closeSheets } from '../controls/dialogs.js';
import { closeFit } from './fit_card.js';
import { closeGuide } from '../guide/guide.js';
import { leaveControl } from '../controls/focus.js';
import { cancelJob } from './job.js';
import { closeMenu } from '../controls/menu.js';

/** End one thing; tells whether there was anything. */
export function escape() {
  return closeSheets() || closeMenu() || leaveControl() || closeFit() || closeGuide() || cancelJob();
}
